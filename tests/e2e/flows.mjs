// What a person does with the page, as checks. Those marked `anywhere` also run against any real server whose newest
// scored attempt, not itself the reference, deviates from its reference by about 0.3 mm somewhere, as the
// demonstration's does.
import { accessFlows } from "./access_flows.mjs";
import { adminFlows } from "./admin_flows.mjs";
import { compareFlows } from "./compare_flows.mjs";
import { demoFlows } from "./demo_flows.mjs";
import { generalFlows } from "./general_flows.mjs";
import { gradingFlows } from "./grading_flows.mjs";
import { insightFlows } from "./insight_flows.mjs";
import { markingFlows } from "./marking_flows.mjs";
import { playbackFlows } from "./playback_flows.mjs";
import { reviewFlows } from "./review_flows.mjs";
import { screenFlows } from "./screens.mjs";
import { teachingFlows } from "./teaching_flows.mjs";
import { turningFlows } from "./turning_flows.mjs";

// Looks at an attempt from every side, which only ./check --full takes: they are a third of the time, and few commits touch
// the viewer. Others are marked `seldom` where they stand.
const seldom = (flows) => flows.map((flow) => ({ ...flow, seldom: true }));

export const flows = [
  ...generalFlows,
  ...accessFlows,
  ...reviewFlows,
  ...seldom(turningFlows),
  ...seldom(compareFlows),
  ...seldom(playbackFlows),
  ...screenFlows,
  ...adminFlows,
  ...teachingFlows,
  ...gradingFlows,
  ...markingFlows,
  ...insightFlows,
  ...demoFlows,
];
