# Turns INPUT (text) into OUTPUT, a C++ source whose FUNCTION of report/page_parts.h returns it.
file(READ "${INPUT}" text)
# A map of the source would be looked for beside the report, where it is not.
string(REGEX REPLACE "\n//# sourceMappingURL=[^\n]*" "" text "${text}")
# Compilers limit the length of one string literal; adjacent ones are joined.
set(pieces "")
string(LENGTH "${text}" length)
set(begin 0)
while(begin LESS length)
  string(SUBSTRING "${text}" ${begin} 12000 piece)
  string(APPEND pieces "    R\"page_part(${piece})page_part\"\n")
  math(EXPR begin "${begin} + 12000")
endwhile()
file(WRITE "${OUTPUT}" "#include \"report/page_parts.h\"\n\nnamespace occlude::tools {\n\n"
     "const char* ${FUNCTION}()\n{\n    return\n${pieces}    ;\n}\n\n} // namespace occlude::tools\n")
