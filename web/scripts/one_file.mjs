// One HTML file that needs nothing else: no server, no network.
import { createHash } from "node:crypto";
import { writeFileSync } from "node:fs";

const hash = (text) => `'sha256-${createHash("sha256").update(text).digest("base64")}'`;
const kEscapes = { "&": "&amp;", "<": "&lt;", ">": "&gt;" };
const escaped = (text) => text.replace(/[&<>]/g, (found) => kEscapes[found]);

// "<" could end the element, so it is written as a JSON escape.
const element = ([id, held]) =>
  typeof held === "string"
    ? `<script type="text/plain" id="${id}">${held}</script>\n`
    : `<script type="application/json" id="${id}">${JSON.stringify(held).replaceAll("<", "\\u003c")}</script>\n`;

// `script`, `style`: bundled (report_parts.mjs). `held`: what the script reads, by the id of its element: a bundled script,
// or what becomes JSON. `allowed`: what the policy admits beside script and style. `icon`: SVG.
export function oneFile({ title, script, style, held, allowed = "", icon }) {
  // The policy lets the browser run and load only what is in this file.
  const policy = `default-src 'none'; script-src ${hash(script)}; style-src ${hash(style)}; ${allowed}base-uri 'none'; form-action 'none'`;
  const link =
    icon === undefined
      ? ""
      : `<link rel="icon" type="image/svg+xml" href="data:image/svg+xml;base64,${Buffer.from(icon).toString("base64")}">\n`;
  return `<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="${policy}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>${escaped(title)}</title>
${link}<style>${style}</style>
</head>
<body>
<div id="app"></div>
${Object.entries(held).map(element).join("")}<script>${script}</script>
</body>
</html>
`;
}

// What the system says of a path, in words.
const kReasons = {
  ENOENT: "nothing there",
  ENOTDIR: "a file where a folder should be",
  EISDIR: "a folder",
  EACCES: "no permission",
  EPERM: "no permission",
  EROFS: "a disk that is read only",
  ENOSPC: "a full disk",
};
export const reason = (error) => kReasons[error.code] ?? error.message;

export function write(to, text) {
  try {
    writeFileSync(to, text);
  } catch (error) {
    throw new Error(
      `${to}: expected a file that can be written, found ${error.code === "ENOENT" ? "no such folder" : reason(error)}; name another`,
    );
  }
}
