import { say, sayIf } from "../../base/words";

// What the numbers of a device profile are called (schemas/device_profile.schema.json).

const kUnits = ["mn_per_mm", "mn_s_per_m", "nm", "um", "mn", "ms", "g", "hz", "ticks"] as const;
const kUnitTexts: Readonly<Record<Exclude<(typeof kUnits)[number], "ticks">, string>> = {
  mn_per_mm: "mN/mm",
  mn_s_per_m: "mN s/m",
  nm: "nm",
  um: "µm",
  mn: "mN",
  ms: "ms",
  g: "g",
  hz: "Hz",
};

// "max_stiffness": "Max stiffness". One that the page does not know is shown by its name.
export function numberTitle(name: string): string {
  const words = name.replaceAll("_", " ");
  return sayIf(`profile_number.${name}`) ?? words.charAt(0).toUpperCase() + words.slice(1);
}

// "max_stiffness_mn_per_mm": "Max stiffness (mN/mm)".
export function memberTitle(member: string): string {
  const unit = kUnits.find((each) => member.endsWith(`_${each}`));
  if (unit === undefined) return numberTitle(member);
  return say("profile_editor.with_unit", {
    number: numberTitle(member.slice(0, -unit.length - 1)),
    unit: unit === "ticks" ? say("calibration.ticks") : kUnitTexts[unit],
  });
}
