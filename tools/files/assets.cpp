#include "files/assets.h"

#include <fmt/format.h>

#include <cstdlib>
#include <vector>

namespace occlude::tools {

Result<std::filesystem::path> find_asset(const std::string& name)
{
    namespace fs = std::filesystem;
    std::vector<fs::path> folders;
    if (const char* chosen = std::getenv("OCCLUDE_ASSETS")) {
        folders.emplace_back(chosen);
    }
    std::error_code failed;
    const fs::path program = fs::read_symlink("/proc/self/exe", failed);
    if (!failed) {
        folders.push_back(program.parent_path().parent_path() / "share/occlude/assets");
    }
    folders.emplace_back(OCCLUDE_SOURCE_ASSETS);
    std::string looked;
    for (const fs::path& folder : folders) {
        if (fs::exists(folder / name, failed)) {
            return folder / name;
        }
        looked += fmt::format("{}{}", looked.empty() ? "" : ", ", folder.string());
    }
    return Error{
        ErrorCode::not_found,
        fmt::format("{} is in none of {}; set OCCLUDE_ASSETS to the folder 'assets' of the "
                    "sources",
                    name, looked)};
}

} // namespace occlude::tools
