// The files that Assimp opens.
#pragma once

#include <assimp/DefaultIOSystem.h>

#include <glm/vec3.hpp>

#include <string>
#include <string_view>
#include <vector>

namespace occlude::tools {

/// Notes which files are opened, hands over text in UTF-16 as UTF-8, which is what most of Assimp's
/// readers take, and moves the vertices of an OBJ file that lie far from the origin toward it:
/// Assimp reads numbers in single precision, which at 4,000 km leaves half metres.
class AssimpFiles : public Assimp::DefaultIOSystem {
public:
    /// `scene`: the file that may be moved.
    explicit AssimpFiles(std::string scene)
        : scene_(std::move(scene))
    {
    }

    Assimp::IOStream* Open(const char* name, const char* mode) override;

    /// What was subtracted from all vertices.
    const glm::dvec3& offset() const { return offset_; }
    const std::vector<std::string>& opened() const { return opened_; }

private:
    /// The text to read instead of a file; empty: the file itself.
    std::string replaced_text(const std::string& file);

    std::string scene_;
    glm::dvec3 offset_{0.0};
    std::vector<std::string> opened_;
};

/// The way from the origin to the bulk of the vertices of an OBJ text, rounded to its size; zero if
/// the bulk lies no farther away than `kFarRatio` times its extent.
glm::dvec3 far_offset_of_obj(std::string_view text);
/// The text with `offset` subtracted from all vertices.
std::string moved_obj(std::string_view text, const glm::dvec3& offset);
inline constexpr double kFarRatio = 16.0;

/// UTF-16 text, by its byte order mark, as UTF-8; empty if it is none, or broken.
std::string utf8_of_utf16(std::string_view text);

} // namespace occlude::tools
