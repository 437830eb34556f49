// Maps of what a hand can feel for the mock server: invented figures, the softer the device the worse.
const kSpeeds = [0.1, 0.2, 0.43, 1];
const kTissues = [[["enamel", "neighbour"], 8700], [["dentin"], 5200], [["caries"], 1000], [["pulp"], 300]];
const kThresholds = [
  { name: "force", value: 0.07, unit: "share", source: "Jones 1989, Perception 18:681; Pang, Tan and Durlach 1991, Perception & Psychophysics 49:531" },
  { name: "viscosity", value: 0.19, unit: "share", source: "Jones, Hunter and Lafontaine 1997, Perception 26:1571" },
  { name: "delay", value: 0.015, unit: "s", source: "Rank, Shi, Mueller and Hirche 2010, EuroHaptics, LNCS 6191, chapter 30" },
];

const holds = (figures) => figures.error <= 0.07 && (figures.lag_s ?? figures.rise_s) <= 0.015;

function verdictOf(law, oracle, forceN, continuousN) {
  if (forceN > continuousN) return "beyond_force";
  if (holds(law)) return "felt";
  if (law.error <= 0.07) return "late";
  if (law.error <= 0.19) return "nearly";
  return holds(oracle) ? "law_falls_short" : "device_cannot";
}

function cell(tissue, bNSPerMm, speed, motion, device) {
  const slow = bNSPerMm / device.kcNPerMm;
  const steady = motion === "steady";
  const forceN = bNSPerMm * speed * (steady ? 1 : 1.195);
  const figures = (share) => {
    const error = steady ? 0.1 * device.cellN * share / forceN : Math.min(0.95, 0.55 * share * slow ** 0.8);
    return { error, gain: 1 - error ** 1.5, lag_s: steady ? null : 0.08 * share * slow, rise_s: steady ? 0.93 * share * slow : null };
  };
  const [law, oracle] = [figures(1), figures(0.4)];
  return { tissue, speed_mm_per_s: speed, motion, force_rms_n: forceN, force_largest_n: steady ? forceN : 1.875 * bNSPerMm * speed, law, oracle,
           verdict: verdictOf(law, oracle, forceN, device.continuousN) };
}

const kDevices = { phantom_desktop: { kcNPerMm: 1.2, cellN: 0.02, continuousN: 1.75 }, omega_6: { kcNPerMm: 20, cellN: 0.06, continuousN: 12 } };

export function feelOf(profile) {
  const device = kDevices[profile.name] ?? kDevices.omega_6;
  return {
    name: profile.name, title: profile.title, version: profile.version, has_motors: true, coupling_mn_per_mm: 1000 * device.kcNPerMm, delay_ticks: 1, delay_measured: false,
    thresholds: kThresholds, tissues_of_scenes: true, tissues_left_out: 0,
    tissues: kTissues.map(([names, damping]) => ({ names, damping_mn_s_per_mm: damping, coulomb_mn: 0, threshold_mn: 0, provenance: "assumption", scenes: ["Lower first molar"] })),
    cells: kTissues.flatMap(([, damping], tissue) => kSpeeds.flatMap((speed) => ["steady", "strokes"].map((motion) => cell(tissue, damping / 1000, speed, motion, device)))),
  };
}
