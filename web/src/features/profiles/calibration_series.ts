import type { CalibrationEntry } from "../../api/types";
import { say } from "../../base/words";
import type { TrendPoint } from "../../widgets/trend";

// With what the page reads of its document (schemas/calibration.schema.json).
export type Calibration = Omit<CalibrationEntry, "document"> & {
  readonly document: {
    readonly station: string;
    readonly software: string;
    readonly method: string;
    readonly measured: Readonly<Record<string, { readonly value: number; readonly uncertainty: number }>>;
  };
};

// The quantities of a calibration document (schemas/calibration.schema.json), as the page draws
// them: in units people read, next to what the profile says.
interface Quantity {
  readonly name:
    | "resolution_nm"
    | "noise_nm"
    | "friction_mn"
    | "damping_mn_s_per_m"
    | "mass_g"
    | "bus_delay_ticks"
    | "answer_us"
    | "answer_jitter_us"
    | "structural_mode_hz"; // in the document
  readonly unit: string;
  readonly factor: number; // from the document's unit to `unit`
  readonly profile: string | undefined; // the profile's number that claims it
}

const kQuantities: readonly Quantity[] = [
  { name: "resolution_nm", unit: "µm", factor: 1e-3, profile: "resolution" },
  { name: "noise_nm", unit: "µm", factor: 1e-3, profile: undefined },
  { name: "friction_mn", unit: "mN", factor: 1, profile: "friction" },
  { name: "damping_mn_s_per_m", unit: "mN·s/m", factor: 1, profile: "damping" },
  { name: "mass_g", unit: "g", factor: 1, profile: "mass" },
  {
    name: "bus_delay_ticks",
    get unit() {
      return say("calibration.ticks");
    },
    factor: 1,
    profile: "bus_delay",
  },
  { name: "answer_us", unit: "µs", factor: 1, profile: undefined },
  { name: "answer_jitter_us", unit: "µs", factor: 1, profile: undefined },
  { name: "structural_mode_hz", unit: "Hz", factor: 1, profile: "structural_mode" },
];

export interface CalibrationSeries {
  readonly title: string;
  readonly unit: string;
  readonly points: readonly TrendPoint[]; // oldest first
  readonly claim: number | undefined; // what the profile says
}

// One series for each quantity that was measured at all. `numbers`: the profile's, by name.
export function calibrationSeries(
  calibrations: readonly Calibration[],
  numbers: ReadonlyMap<string, number>,
): CalibrationSeries[] {
  const oldestFirst = [...calibrations].sort((a, b) => a.measured_ms - b.measured_ms);
  return kQuantities.flatMap(({ name, unit, factor, profile }) => {
    const points = oldestFirst.flatMap((calibration) => {
      const measure = measureOf(calibration, name);
      return measure === undefined
        ? []
        : [{ atMs: calibration.measured_ms, value: measure.value * factor, uncertainty: measure.uncertainty * factor }];
    });
    const claim = profile === undefined ? undefined : numbers.get(profile);
    return points.length === 0
      ? []
      : [
          {
            title: say(`calibration_figure.${name}`),
            unit,
            points,
            claim: claim === undefined ? undefined : claim * factor,
          },
        ];
  });
}

function measureOf(
  calibration: Calibration,
  name: string,
): { readonly value: number; readonly uncertainty: number } | undefined {
  const measured = calibration.document.measured as Readonly<
    Record<string, { readonly value: number; readonly uncertainty: number } | undefined>
  >;
  const measure = measured[name];
  return measure !== undefined && Number.isFinite(measure.value) && Number.isFinite(measure.uncertainty)
    ? measure
    : undefined;
}
