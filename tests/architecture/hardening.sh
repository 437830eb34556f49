#!/bin/sh
# The built programs are hardened, as their ELF headers say: hardening.sh PROGRAM...
# What CMakeLists.txt asks the compiler for is one thing, what the linker made of it another.
set -u
export LC_ALL=C
failed=0
for program in "$@"; do
  name=$(basename "$program")
  headers=$(readelf -W --file-header --program-headers --dynamic "$program") || { echo "$name: readelf cannot read it"; failed=1; continue; }
  symbols=$(readelf -W --dyn-syms "$program")
  need() { # need WHAT TEXT PATTERN
    echo "$2" | grep -qE "$3" || { echo "$name: expected $1, found none"; failed=1; }
  }
  need "a program that is loaded anywhere (PIE)" "$headers" 'Type: +DYN \(Position-Independent'
  need "GNU_RELRO" "$headers" '^ +GNU_RELRO '
  need "BIND_NOW, without which RELRO leaves the call table writable" "$headers" 'BIND_NOW|Flags:.* NOW'
  need "a stack that is not executable" "$headers" '^ +GNU_STACK( +0x[0-9a-f]+){5} RW +'
  need "guarded stacks (-fstack-protector-strong)" "$symbols" ' __stack_chk_fail(@|$)'
  need "checked copies (_FORTIFY_SOURCE)" "$symbols" ' __[a-z]+_chk(@|$)'
  need "checked indices (_GLIBCXX_ASSERTIONS)" "$symbols" 'glibcxx_assert_fail'
  [ "$(uname -m)" = x86_64 ] || continue
  code=$(objdump -d --no-show-raw-insn --section=.text "$program" | cut -f 2-)
  # The smallest program has 231; what a library brings has 3 by itself.
  [ "$(echo "$code" | grep -c endbr64)" -ge 100 ] || { echo "$name: expected marked targets of calls (-fcf-protection), found few"; failed=1; }
  need "large stacks touched page by page (-fstack-clash-protection)" "$code" 'or[bwlq]? +\$0x0,(0x[0-9a-f]+)?\(%rsp'
done
exit $failed
