# The commands in a guide's blocks, one on each line, without comments: guide_blocks FILE FENCE…. FENCE begins a block, such as
# '```sh'. Sourced by scripts.
guide_blocks() {
  local file=$1
  shift
  awk -v fences="$(printf '%s\n' "$@")" '
    BEGIN { n = split(fences, list, "\n"); for (i = 1; i <= n; ++i) begins[list[i]] }
    { line = $0; sub(/^ +/, "", line) }
    !on && line ~ /^```/ { on = 1; taken = line in begins; text = ""; next }
    on && line == "```" { on = 0; if (taken && text !~ /▶/) printf "%s", text; next }
    on && line != "" {
      sub(/ +#.*$/, "", line)
      if (sub(/ *\\$/, "", line)) text = text line " "; else text = text line "\n"
    }' "$file"
}
