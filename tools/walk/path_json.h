// How path files are read: JSON whose errors name the file, the entry and what it must hold.
#pragma once

#include "files/json.h"

#include <occlude/core/result.h>

#include <glm/vec3.hpp>

#include <initializer_list>
#include <string>

namespace occlude::tools {

/// An error in a path file.
Error bad_path(const std::string& file, const std::string& what);

/// Reads a path file as far as all kinds of it are alike: an object of version 1 without unknown
/// keys.
Result<Json> read_path_json(const std::string& file);

/// Reads members of one entry, and keeps the first thing that was wrong.
class PathEntry {
public:
    /// `place` is how errors call the entry; `example` is what it should look like.
    PathEntry(const Json& value, std::string place, const char* example);

    bool has(const char* key) const { return value_.contains(key); }
    /// Fails if there is no such member.
    void require(const char* key);
    /// Fails if there is a member that is not among `keys`, and names the nearest of them.
    void allow_only(std::initializer_list<const char*> keys);
    /// Each reads a member into `out` if it is there, and fails if it is of another kind.
    void read(const char* key, glm::vec3& out);
    void read(const char* key, glm::dvec3& out);
    void read(const char* key, float& out, float least, float most);
    void read(const char* key, uint32_t& out, uint32_t most);
    void read(const char* key, bool& out);

    void fail(std::string problem);
    const std::string& place() const { return place_; }
    /// What was wrong first; empty if nothing was.
    const std::string& problem() const { return problem_; }

private:
    const Json& value_;
    std::string place_;
    std::string problem_;
};

} // namespace occlude::tools
