# Writes OUT, the source that VersionText takes version and commit from, whenever they have changed:
#   cmake -D SOURCE=… -D VERSION=… -D OUT=… -P commit.cmake
# At each build, because a commit changes no file that the build looks at.
cmake_minimum_required(VERSION 3.25)
execute_process(COMMAND git --no-optional-locks -C ${SOURCE} describe --always --exclude=* --abbrev=12 --dirty=-changed
                OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(DEFINED ENV{ENAMEL_COMMIT})  # sources without their git folder
  set(commit $ENV{ENAMEL_COMMIT})
endif()
file(CONFIGURE OUTPUT ${OUT} CONTENT "#include \"common/program/commit.h\"

namespace enamel::program {
const char kVersion[] = \"@VERSION@\";
const char kCommit[] = \"@commit@\";
}  // namespace enamel::program
" @ONLY)
