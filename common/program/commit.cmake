# Writes OUT, the source that VersionText takes version and commit from, whenever they have changed:
#   cmake -D SOURCE=… -D VERSION=… -D OUT=… -P commit.cmake
# At each build, because a commit changes no file that the build looks at.
cmake_minimum_required(VERSION 3.25)
execute_process(COMMAND ${SOURCE}/packaging/commit OUTPUT_VARIABLE commit ERROR_QUIET)
string(REGEX REPLACE " .*" "" commit "${commit}")
file(CONFIGURE OUTPUT ${OUT} CONTENT "#include \"common/program/commit.h\"

namespace enamel::program {
const char kVersion[] = \"@VERSION@\";
const char kCommit[] = \"@commit@\";
}  // namespace enamel::program
" @ONLY)
