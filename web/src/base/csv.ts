// Comma-separated values as spreadsheets read them (RFC 4180, UTF-8 with a byte order mark, without
// which Excel takes it for the local code page).

export type Cell = string | number | boolean | null;

const kByteOrderMark = "\uFEFF";
const kLineEnd = "\r\n";
// What a spreadsheet takes for a formula at the start of a cell (OWASP, "CSV Injection"), also the
// full-width forms some of them accept.
const kFormulaStart = /^[=+\-@\t\r\n\uFF0B\uFF0D\uFF1D\uFF20]/;

// Text that would be a formula gets an apostrophe in front, which spreadsheets do not show. Numbers
// are written as they are: a minus there is a minus.
export function csvText(header: readonly string[], rows: ReadonlyArray<readonly Cell[]>): string {
  return kByteOrderMark + [header, ...rows].map((row) => row.map(cellText).join(",") + kLineEnd).join("");
}

function cellText(cell: Cell): string {
  if (cell === null) return "";
  if (typeof cell === "number") return Number.isFinite(cell) ? String(cell) : "";
  if (typeof cell === "boolean") return cell ? "yes" : "no";
  const harmless = kFormulaStart.test(cell) ? `'${cell}` : cell;
  return /[",\r\n]/.test(harmless) ? `"${harmless.replaceAll('"', '""')}"` : harmless;
}
