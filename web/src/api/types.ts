import type * as api from "../../build/api";

// What schemas/api/openapi.yaml describes, under its own names; the shapes are generated from it at build time. Parts
// of them that have no name there:
export type * from "../../build/api";

export type Mentions = api.ErasureReport["mentions"][number];
export type CohortMember = api.Cohort["members"][number];
export type MarkingResults = NonNullable<api.Marking["results"]>;
export type ToothWanted = Omit<
  api.operations["beginToothImport"]["requestBody"]["content"]["application/json"],
  "file_name" | "bytes"
>;
export type Deduction = api.Score["deductions"][number];
export type Envelope = NonNullable<api.Score["envelope"]>;
export type Criterion = api.Score["criteria"][number];
export type Region = api.Score["regions"][number];
export type Mistake = api.Score["mistakes"][number];
export type Metric = api.Score["metrics"][number];
