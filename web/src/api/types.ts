import type { components } from "../../build/api";

// Names for what schemas/api/openapi.yaml describes; the shapes are generated from it at build time.
type Schemas = components["schemas"];

export type Person = Schemas["Person"];
export type Role = Schemas["Role"];
export type Session = Schemas["Session"];
export type ExerciseSummary = Schemas["ExerciseSummary"];
export type Exercise = Schemas["Exercise"];
export type Bur = Schemas["Bur"];
export type Cohort = Schemas["Cohort"];
export type Attempt = Schemas["Attempt"];
export type AttemptDetail = Schemas["AttemptDetail"];
export type AttemptState = Schemas["AttemptState"];
export type Score = Schemas["Score"];
export type Criterion = Score["criteria"][number];
export type Metric = Score["metrics"][number];
export type Series = Schemas["Series"];
export type Profile = Schemas["Profile"];
export type Station = Schemas["Station"];
export type AuditEntry = Schemas["AuditEntry"];
export type Job = Schemas["Job"];
export type ErrorCode = Schemas["Error"]["error"]["code"];

export interface AttemptPage {
  readonly attempts: readonly Attempt[];
  readonly next: string | null;
}
