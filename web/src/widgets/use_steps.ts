import { useEffect, useState } from "preact/hooks";

// Counts up to `last` once `begun`, one a frame: parts of a screen that come one after the other leave room for what
// cannot wait, as a keystroke or a picture.
export function useSteps(begun: boolean, last: number): number {
  const [step, setStep] = useState(0);
  useEffect(() => {
    if (!begun || step >= last) return undefined;
    const handle = requestAnimationFrame(() => setStep(step + 1));
    return () => cancelAnimationFrame(handle);
  }, [begun, step, last]);
  return step;
}
