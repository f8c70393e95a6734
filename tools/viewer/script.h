// A script of inputs for the viewer, one a line, for tests and for making pictures:
//
//   # a comment
//   wait 3                      frames
//   key F1                      press and release; "key ctrl+F"
//   hold W 10                   hold for this many frames
//   move 400 300                the mouse, in pixels of the window from its upper left corner
//   click 400 300               or: click "Freeze", the middle of what has that label
//   drag 400 300 500 320        with the left button; "drag right 400 300 500 320"
//   scroll 2                    wheel notches, up is positive
//   type castle                 characters
//   drop FILE                   a file on the window
//   resize 900x600              the window
//   wait-loaded                 until the scene is there
//   wait-text TEXT              until the window shows TEXT
//   assert-text TEXT            the panels and the picture's texts show TEXT
//   assert-no-text TEXT
//   screenshot FILE.png
#pragma once

#include <occlude/core/result.h>

#include <glm/vec2.hpp>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace occlude::tools::viewer {

struct ScriptStep {
    enum class Kind : uint8_t {
        wait,
        key,
        hold,
        move,
        click,
        click_label,
        drag,
        scroll,
        type,
        drop,
        resize,
        wait_loaded,
        wait_text,
        assert_text,
        assert_no_text,
        screenshot,
    };
    Kind kind = Kind::wait;
    int line = 0;  ///< in the script, from 1
    int count = 0; ///< frames, or notches
    int key = 0;   ///< a code of keys.h
    bool control = false;
    int button = 0;    ///< 0: left, 1: right
    glm::vec2 from{0}; ///< pixels of the window
    glm::vec2 to{0};
    std::string text = {};
};

/// Errors name the script, the line, what is wrong with it and what it must look like.
Result<std::vector<ScriptStep>> parse_script(std::string_view text, const std::string& name);
Result<std::vector<ScriptStep>> read_script(const std::string& file);

} // namespace occlude::tools::viewer
