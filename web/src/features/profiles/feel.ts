import type { Profile } from "../../api/types";

// Up to which stiffness of its grip a hand feels F = B v of a device: the closed form of
// common/fidelity/felt.h, for a plain spring of the coupling's stiffness, without friction.

// Shares that a hand can tell in force and viscosity, and one between; how quickly a hand works a
// surface; the range of grips (common/fidelity/feel.h, and its sources).
export const kShares = [0.07, 0.15, 0.19] as const;
const kHandRadPerS = 1.6;
const kSoftest = 0.3;
const kStiffest = 20;

// The built-in tissues (common/scene/builtin), hard to soft.
export const kTissues = [
  { name: "enamel", damping: 8.7 },
  { name: "dentin", damping: 5.2 },
  { name: "caries", damping: 1 },
  { name: "pulp", damping: 0.3 },
] as const;

// The coupling's stiffness in N/mm, undefined for a device without motors: its force is computed and shown, not felt.
export function couplingOf({ name, numbers }: Pick<Profile, "name" | "numbers">): number | undefined {
  const coupling = numbers.find((number) => number.name === "coupling")?.value ?? 0; // mN/mm
  return name === "pointer" || coupling <= 0 ? undefined : coupling / 1000;
}

// |H/H_ideal - 1| of H = kt s/(s + kt/B), kt = kh K/(kh + K), against kh s/(s + kh/B). N/mm and N s/mm.
export function closedFormError(grip: number, spring: number, damping: number): number {
  const both = (grip * spring) / (grip + spring);
  // H/H_ideal = (both/grip) (jw + grip/B)/(jw + both/B).
  const [a, b] = [grip / damping, both / damping];
  const size = kHandRadPerS ** 2 + b ** 2;
  const real = (both / grip) * ((kHandRadPerS ** 2 + a * b) / size);
  const imaginary = (both / grip) * ((kHandRadPerS * (b - a)) / size);
  return Math.hypot(real - 1, imaginary);
}

// The stiffest such grip, N/mm; 0: below the softest, Infinity: any.
export function stiffestGrip(spring: number, damping: number, share: number): number {
  const within = (grip: number) => closedFormError(grip, spring, damping) <= share;
  if (!within(kSoftest)) return 0;
  if (within(kStiffest)) return Number.POSITIVE_INFINITY;
  let [low, high] = [kSoftest, kStiffest];
  for (let i = 0; i < 40; i++) {
    const middle = (low + high) / 2;
    if (within(middle)) low = middle;
    else high = middle;
  }
  return low;
}
