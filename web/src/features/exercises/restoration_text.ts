import { nameOf } from "../../api/builtin_words";
import type { Exercise } from "../../api/types";
import { say, sayIf } from "../../base/words";
import { fullMarksText, type MarkMap, noMarksText } from "./exercise_text";

// What a restorative material changes in a rubric, in words.

const kTellingWords = 3;

type Restoration = NonNullable<Exercise["rubric"]["restoration"]>;

// Where the limits come from: the server's sentence, which is English, or a school's own. The material and the last
// words tell the built-in ones apart.
export function sourceText({ name, source }: Pick<Restoration, "name" | "source">): string {
  const end = nameOf(source).split("_").slice(-kTellingWords).join("_");
  return sayIf(`restoration_source.${name}_${end}`) ?? source;
}

// Metrics whose limits are degrees beyond the range that a material allows the walls.
const kBeyondRange: ReadonlySet<string> = new Set(["undercut_deg", "wall_tilt_deg"]);

// From where on a criterion gives all of its points, and from where on none.
export function marksTexts(
  { metric, map, unit }: { readonly metric: string; readonly map: MarkMap; readonly unit: string },
  restoration: Restoration | null,
): readonly [full: string, none: string] {
  if (restoration?.divergence_deg == null || !kBeyondRange.has(metric))
    return [fullMarksText(map, unit), noMarksText(map, unit)];
  const full = Math.max(...map.filter((point) => point.share >= 1).map((point) => point.value));
  const beyond = (limit: string) => say("restoration.beyond", { limit });
  return [full > 0 ? beyond(fullMarksText(map, unit)) : say("restoration.in_range"), beyond(noMarksText(map, unit))];
}

// How far the material lets walls lean: "Amalgam: mesial and distal walls may diverge by −2° to 10°, …".
export function restorationText({ name, divergence_deg: ranges }: Restoration): string {
  const material = say(`material.${name}`);
  const range = ([from = 0, to = 0]: readonly number[]) =>
    fullMarksText(
      [
        { value: from - 1, share: 0 },
        { value: from, share: 1 },
        { value: to, share: 1 },
        { value: to + 1, share: 0 },
      ],
      "deg",
    );
  return ranges === null
    ? material
    : say("restoration.ranges", {
        material,
        mesiodistal: range(ranges.mesiodistal),
        buccolingual: range(ranges.buccolingual),
      });
}
