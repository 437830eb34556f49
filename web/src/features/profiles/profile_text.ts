// What the numbers of a device profile are called (schemas/device_profile.schema.json).

const kUnits = ["mn_per_mm", "mn_s_per_m", "nm", "um", "mn", "g", "hz", "ticks"] as const;
const kUnitTexts: Readonly<Record<(typeof kUnits)[number], string>> = { mn_per_mm: "mN/mm", mn_s_per_m: "mN s/m", nm: "nm", um: "µm", mn: "mN", g: "g", hz: "Hz", ticks: "ticks" };

// "max_stiffness_mn_per_mm": "Max stiffness (mN/mm)".
export function memberTitle(member: string): string {
  const unit = kUnits.find((each) => member.endsWith(`_${each}`));
  const words = (unit === undefined ? member : member.slice(0, -unit.length - 1)).replaceAll("_", " ");
  const title = words.charAt(0).toUpperCase() + words.slice(1);
  return unit === undefined ? title : `${title} (${kUnitTexts[unit]})`;
}
