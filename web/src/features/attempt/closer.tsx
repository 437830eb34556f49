// What a tooth needs once it is cut open, measured or compared with another one, or its figures are unfolded, how the
// hand moved in an exam, still views where there is no WebGL, and why there is no score: a part of the page of its own.
export { DeviationFigures } from "./deviation_figures";
export { EvidencePanel } from "./evidence_panel";
export { CompareBar, OtherTooth } from "./other_tooth";
export { Measured } from "./profile";
export { SectionLegend } from "./section_legend";
export { SectionTools } from "../../widgets/tooth/section_tools";
export { StillViews } from "../../widgets/tooth/still_views";
export { Problem, Unscored } from "./unscored";
