// Options that several commands take, for the command line.
#pragma once

#include "options/options.h"

#include <CLI/CLI.hpp>

#include <cstdint>

namespace occlude::tools {

/// The heading of options about scenes that are files.
inline constexpr const char* kFileGroup = "Scenes that are files";

/// Accepts whole numbers in a range; larger ones than memory could hold are typing errors.
CLI::Validator whole_number(uint64_t low, uint64_t high);

/// --origin, --unit, --up and the limits of reading.
void add_file_options(CLI::App& app, FileOptions& file);

} // namespace occlude::tools
