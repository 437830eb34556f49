// Draws the map of what a hand can feel (schemas/feel.schema.json): felt error of enamel over the
// grip's stiffness, a panel for each device. Reads what `enamel-lab qualify --suite map --json F` wrote:
//   node feel.mjs F > feel.svg
import { readFileSync } from "node:fs";

const { feel } = JSON.parse(readFileSync(process.argv[2], "utf8"));
const grips = feel.grips_n_per_mm;
const curves = feel.curves.filter((curve) => curve.tissue === "enamel");
const devices = [...new Set(curves.map((curve) => curve.device))];

const panel = { width: 226, height: 168, left: 34, top: 22, gap: 12 };
const columns = 5;
const head = 62;
const plot = { width: panel.width - panel.left - 8, height: panel.height - panel.top - 24 };
const width = columns * (panel.width + panel.gap) + panel.gap;
const height = head + Math.ceil((devices.length + 1) / columns) * (panel.height + panel.gap) + 4;
const most = 0.6;
const firmest = 2; // N/mm, of a hand (common/fidelity/feel.h)
const kBlue = "#1565c0";
const kOrange = "#e67700";
const kGrey = "#8a8f98";

const x = (grip) => (Math.log(grip / grips[0]) / Math.log(grips.at(-1) / grips[0])) * plot.width;
const y = (error) => plot.height * (1 - Math.min(error, most) / most);
const escaped = (text) => text.replaceAll("&", "&amp;").replaceAll("<", "&lt;");
const text = (at, up, content, more = "") => `<text x="${at}" y="${up}" ${more}>${escaped(content)}</text>`;

function line(values, colour, more = "") {
  const points = values.map((value, i) => `${x(grips[i]).toFixed(1)},${y(value).toFixed(1)}`).join(" ");
  return `<polyline points="${points}" fill="none" stroke="${colour}" stroke-width="1.8" ${more}/>`;
}

const kDashed = 'stroke-dasharray="4 3" opacity=".75"';
const own = (of, calibrated = true) => of.find((curve) => curve.limit === "" && curve.calibrated === calibrated);

function drawnIn(device) {
  const of = (law) => curves.filter((curve) => curve.device === device && curve.law === law);
  const [lead, plain] = [of("lead-maxwell"), of("maxwell")];
  return [
    line(own(plain).error, kGrey),
    line(own(lead).closed_form, kBlue, kDashed),
    own(lead, false) === undefined ? "" : line(own(lead, false).error, kOrange),
    line(own(lead).error, kBlue),
  ].join("");
}

function frame() {
  const shares = feel.shares.map(
    (share) =>
      `<line x1="0" x2="${plot.width}" y1="${y(share)}" y2="${y(share)}" stroke="#c62828" stroke-width=".7" opacity=".6"/>`,
  );
  const marks = [0.3, 1, 2, 5, 20].map((grip) =>
    text(x(grip), plot.height + 12, String(grip), 'text-anchor="middle" fill="#555"'),
  );
  const heights = [0, 0.2, 0.4, 0.6].map((error) =>
    text(-4, y(error) + 3, `${Math.round(100 * error)}`, 'text-anchor="end" fill="#555"'),
  );
  return `<rect width="${plot.width}" height="${plot.height}" fill="#fff" stroke="#ccc"/>
<rect width="${x(firmest)}" height="${plot.height}" fill="#fdf3d8"/>${shares.join("")}${marks.join("")}${heights.join("")}`;
}

function place(i) {
  const column = i % columns;
  const row = Math.floor(i / columns);
  return `translate(${panel.gap + column * (panel.width + panel.gap) + panel.left} ${head + row * (panel.height + panel.gap) + panel.top})`;
}

function panelOf(device, i) {
  const curve = own(curves.filter((each) => each.device === device));
  const title = `${curve.title.replace(/ \(.*/, "")}, Kc ${curve.kc_n_per_mm.toFixed(1)} N/mm`;
  return `<g transform="${place(i)}">${text(0, -7, title, 'font-weight="600" font-size="10.5"')}${frame()}${drawnIn(device)}</g>`;
}

function legend() {
  const rows = [
    [kBlue, "", "default law, calibrated"],
    [kOrange, "", "default law, not calibrated"],
    [kGrey, "", "plain spring Kc, calibrated"],
    [kBlue, kDashed, "closed form: spring n·Kc"],
  ].map(
    ([colour, dash, words], i) =>
      `<line x1="0" x2="26" y1="${i * 18}" y2="${i * 18}" stroke="${colour}" stroke-width="1.8" ${dash}/>${text(32, i * 18 + 4, words)}`,
  );
  const notes = [
    `Red: ${feel.shares.map((share) => `${Math.round(100 * share)}`).join(", ")} % error.`,
    "Felt from: force 7 %, viscosity 19 %.",
  ].map((words, i) => text(0, 80 + i * 14, words, 'fill="#555"'));
  return `<g transform="${place(devices.length)}">${rows.join("")}${notes.join("")}</g>`;
}

process.stdout.write(`<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${width} ${height}" font-family="system-ui, sans-serif" font-size="10"><title>How far a hand’s enamel is from F = B·v</title>
<rect width="${width}" height="${height}" fill="#fafafa"/>
${text(panel.gap, 24, "How far a hand’s enamel is from F = B·v, in %, over the stiffness of its grip, in N/mm", 'font-size="15" font-weight="600"')}
${text(panel.gap, 43, "Yellow: grips of a hand. The softer the grip, the less a device’s own spring is felt: a device is good up to where its curve crosses a red line.", 'font-size="11" fill="#444"')}
${devices.map(panelOf).join("\n")}
${legend()}
</svg>
`);
