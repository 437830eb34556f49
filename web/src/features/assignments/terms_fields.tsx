import type { AssignmentTerms, Counting } from "../../api/types";
import { CheckField, NumberField, SelectField, TimeField } from "../../widgets/form";
import { countingText, dueProblem, kCountings, kHands } from "./assignment_text";

export type Terms = Required<Omit<AssignmentTerms, "exercise" | "cohort_id">>;

interface Props {
  readonly terms: Terms;
  readonly onTerms: (part: Partial<Terms>) => void;
  readonly stations: ReadonlyArray<{ readonly id: string; readonly name: string }>;
  readonly problemOf: (field: string) => string | undefined;
}

// When, how often, and whether as an exam.
export function TermsFields({ terms, onTerms, stations, problemOf }: Props) {
  const dueWrong = dueProblem(terms, Date.now());
  const chosen = new Set(terms.station_ids);
  const toggle = (id: string, on: boolean) => onTerms({ station_ids: on ? [...terms.station_ids, id] : terms.station_ids.filter((item) => item !== id) });
  return (
    <>
      <div class="form-grid">
        <TimeField label="Opens" hint="Empty: at once" value={terms.opens_ms} onValue={(opensMs) => onTerms({ opens_ms: opensMs })} problem={problemOf("opens_ms")} />
        <TimeField label="Due" hint="Empty: never" value={terms.due_ms} onValue={(dueMs) => onTerms({ due_ms: dueMs })} problem={problemOf("due_ms") ?? dueWrong} />
        <NumberField label="Attempts for each student" hint="0: no limit" min={0} max={1000} value={terms.attempt_limit}
                     onValue={(limit) => onTerms({ attempt_limit: limit })} problem={problemOf("attempt_limit")} />
        <SelectField<Counting> label="What counts of several attempts" value={terms.counting} onValue={(counting) => onTerms({ counting })}
                               options={kCountings.map((counting) => ({ value: counting, title: countingText(counting) }))} />
      </div>
      <SelectField label="Devices allowed" hint="In graded work and exams. Practice is free." value={terms.hands} onValue={(hands) => onTerms({ hands })}
                   options={kHands} problem={problemOf("hands")} />
      <CheckField label="Late attempts are accepted" hint="After the due time, and marked as late." value={terms.late_allowed} onValue={(late) => onTerms({ late_allowed: late })} />
      <CheckField label="Exam" hint="Begins online, one at a time, made in real time; nothing is shown before you release it." value={terms.exam} onValue={(exam) => onTerms({ exam })} />
      {terms.exam && stations.length > 0 && (
        <fieldset class="group">
          <legend>Stations of the exam</legend>
          <p class="hint">None chosen: any station.</p>
          <div class="check-list">
            {stations.map((station) => <CheckField key={station.id} label={station.name} value={chosen.has(station.id)} onValue={(on) => toggle(station.id, on)} />)}
          </div>
        </fieldset>
      )}
    </>
  );
}
