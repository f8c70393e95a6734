// Text as HTML takes it.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace occlude::tools {

/// `text` with the characters that mean something in HTML replaced.
std::string html_escaped(std::string_view text);

/// JSON that cannot end the script element it stands in.
std::string json_for_script(std::string json);

/// Bytes as the text of a data: address (RFC 4648).
std::string base64(std::string_view bytes);

/// "1 frame", "24 frames".
std::string counted(size_t count, std::string_view thing);

} // namespace occlude::tools
