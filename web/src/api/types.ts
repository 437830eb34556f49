import type { components, operations } from "../../build/api";

// Names for what schemas/api/openapi.yaml describes; the shapes are generated from it at build
// time.
type Schemas = components["schemas"];

export type Target = Schemas["Target"];
export type TargetPart = Schemas["TargetPart"];
export type StumpSection = Schemas["StumpSection"];
export type Person = Schemas["Person"];
export type Role = Schemas["Role"];
export type Session = Schemas["Session"];
export type LanguageChoice = Schemas["Language"];
export type SessionEntry = Schemas["SessionEntry"];
export type PersonDetail = Schemas["PersonDetail"];
export type PersonWithCohorts = Schemas["PersonWithCohorts"];
export type PersonWithPassword = Schemas["PersonWithPassword"];
export type ErasureReport = Schemas["ErasureReport"];
export type Mentions = ErasureReport["mentions"][number];
export type RosterOutcome = Schemas["RosterOutcome"];
export type Cohort = Schemas["Cohort"];
export type ListedCohort = Schemas["ListedCohort"];
export type CohortMember = Cohort["members"][number];
export type Station = Schemas["Station"];
export type EnrolCode = Schemas["EnrolCode"];
export type MadeEnrolCode = Schemas["MadeEnrolCode"];
export type Profile = Schemas["Profile"];
export type ProfileDetail = Schemas["ProfileDetail"];
export type ProfileCriterion = Schemas["ProfileCriterion"];
export type ProfileJudgement = Schemas["ProfileJudgement"];
export type ProfileVersion = Schemas["ProfileVersion"];
export type ProfileReport = Schemas["ProfileReport"];
export type ExerciseSummary = Schemas["ExerciseSummary"];
export type Exercise = Schemas["Exercise"];
export type ExerciseState = Schemas["ExerciseState"];
export type ExerciseVersion = Schemas["ExerciseVersion"];
export type Bur = Schemas["Bur"];
export type TouchCues = Schemas["TouchCues"];
export type Reference = Schemas["Reference"];
export type Assignment = Schemas["Assignment"];
export type AssignmentTerms = Schemas["AssignmentTerms"];
export type AssignmentMove = Schemas["AssignmentMove"];
export type Counting = Schemas["Counting"];
export type ScoringMetric = Schemas["ScoringMetric"];
export type MetricName = Schemas["MetricName"];
export type Unit = Schemas["Unit"];
export type ReasonCode = Schemas["ReasonCode"];
export type RubricPreview = Schemas["RubricPreview"];
export type RubricVersion = Schemas["RubricVersion"];
export type AssignmentInsight = Schemas["AssignmentInsight"];
export type Spread = Schemas["Spread"];
export type MarkingSummary = Schemas["MarkingSummary"];
export type Marking = Schemas["Marking"];
export type MarkingResults = NonNullable<Marking["results"]>;
export type AgreementFigure = Schemas["AgreementFigure"];
export type Grade = Schemas["Grade"];
export type CohortGrades = Schemas["CohortGrades"];
export type SharingEdit = Schemas["SharingEdit"];
export type Attempt = Schemas["Attempt"];
export type AttemptDetail = Schemas["AttemptDetail"];
export type Grading = Schemas["Grading"];
export type AttemptFacts = Schemas["AttemptFacts"];
export type AttemptFlag = Schemas["AttemptFlag"];
export type Hand = Schemas["Hand"];
export type ListedDevice = Schemas["ListedDevice"];
export type HandsAllowed = Schemas["HandsAllowed"];
export type Annotation = Schemas["Annotation"];
export type Remark = Schemas["Remark"];
export type SavedText = Schemas["SavedText"];
export type TextToSave = Schemas["TextToSave"];
export type Appeal = Schemas["Appeal"];
export type ScoringRun = Schemas["ResultRun"];
export type FirstAdmin = Schemas["FirstAdmin"];
export type PutTooth = Schemas["PutTooth"];
export type Backups = Schemas["Backups"];
export type ToothImport = Schemas["ToothImport"];
export type ExerciseTrial = Schemas["ExerciseTrial"];
export type TrialScore = Schemas["TrialScore"];
export type ToothStance = Schemas["ToothStance"];
export type ToothWanted = Omit<
  operations["beginToothImport"]["requestBody"]["content"]["application/json"],
  "file_name" | "bytes"
>;
export type ServerHealth = Schemas["ServerHealth"];
export type Job = Schemas["Job"];
export type AttemptState = Schemas["AttemptState"];
export type Score = Schemas["Score"];
export type Deduction = Score["deductions"][number];
export type Envelope = NonNullable<Score["envelope"]>;
export type Criterion = Score["criteria"][number];
export type Region = Score["regions"][number];
export type Mistake = Score["mistakes"][number];
export type Metric = Score["metrics"][number];
export type Series = Schemas["Series"];
export type Ticks = Schemas["Ticks"];
export type AuditEntry = Schemas["AuditEntry"];
export type LiveEvent = Schemas["LiveEvent"];
export type LiveRemark = Schemas["LiveRemark"];
export type LiveCut = Schemas["LiveCut"];
export type LiveRemarks = Schemas["LiveRemarks"];
export type ErrorCode = Schemas["Error"]["error"]["code"];

// An entry's document is schemas/calibration.schema.json; this is what the page reads of it.
export interface CalibrationDocument {
  readonly station: string;
  readonly software: string;
  readonly method: string;
  readonly measured: Readonly<
    Record<string, { readonly value: number; readonly uncertainty: number; readonly samples: number }>
  >;
}
export type Calibration = Omit<Schemas["CalibrationEntry"], "document"> & { readonly document: CalibrationDocument };
