import type { Marking } from "../../api/types";
import { say } from "../../base/words";

// "Ben Weiss: 4 of 12".
export function progressText({ display_name: name, marked }: Marking["markers"][number], works: number): string {
  return say("marking.progress", {
    name: name === "" ? say("marking.nobody") : name,
    part: String(marked),
    whole: String(works),
  });
}
