#include "commands/cli_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

namespace occlude::tools {

CLI::Validator whole_number(uint64_t low, uint64_t high)
{
    return CLI::Validator{
        [low, high](const std::string& text) {
            constexpr size_t kMaxDigits = 18;
            const bool digits =
                !text.empty() && text.size() <= kMaxDigits &&
                std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
            const uint64_t value = digits ? std::stoull(text) : 0;
            return digits && value >= low && value <= high
                       ? std::string{}
                       : fmt::format("'{}' is not a whole number from {} to {}", text, low, high);
        },
        ""};
}

void add_file_options(CLI::App& app, FileOptions& file)
{
    constexpr uint64_t kMaxSeconds = 1000000;
    constexpr uint64_t kMaxMebibytes = uint64_t{1} << 24;
    const std::string group = kFileGroup;
    app.add_option("--origin", file.origin,
                   "X,Y,Z: the point of the file that becomes (0, 0, 0) (default: moved only where "
                   "single precision would bend it)")
        ->group(group);
    app.add_option("--unit", file.unit,
                   "m, cm, mm, in, ft, or how many units make a metre (default: as the file or its "
                   "format says, else guessed)")
        ->group(group);
    app.add_option("--up", file.up, "x, y, z, or -x, -y, -z (default: as for --unit)")
        ->group(group);
    app.add_option("--load-seconds", file.load_seconds,
                   "How long Assimp may read a file before it is stopped")
        ->capture_default_str()
        ->check(whole_number(1, kMaxSeconds))
        ->group(group);
    app.add_option("--load-memory", file.load_memory_mib,
                   "MiB that reading a file may take (default: half of the machine's)")
        ->check(whole_number(1, kMaxMebibytes))
        ->group(group);
}

} // namespace occlude::tools
