import type { ColorMode, SectionPlane } from "../../tooth/messages";

// What somebody has chosen to see of a tooth.
export interface ToothChoices {
  readonly mode: ColorMode;
  readonly section: SectionPlane | undefined;
  readonly follow: boolean;
  readonly target: boolean; // what the exercise asks for is drawn
}
