import type { AssignmentTerms, Counting } from "../../api/types";
import { say } from "../../base/words";
import { CheckField, NumberField, SelectField, TimeField } from "../../widgets/form";
import { countingText, dueProblem, handsText, kCountings, kHands, kOutlines, outlineText } from "./assignment_text";

export type Terms = Required<Omit<AssignmentTerms, "exercise" | "cohort_id">>;

// What only exams have is taken off other work.
export function fitting(terms: Terms): Terms {
  return terms.exam ? terms : { ...terms, station_ids: [], sign_off: false };
}

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
  const toggle = (id: string, on: boolean) =>
    onTerms({ station_ids: on ? [...terms.station_ids, id] : terms.station_ids.filter((item) => item !== id) });
  return (
    <>
      <div class="form-grid">
        <TimeField
          label={say("assignments.opens")}
          hint={say("terms.empty_at_once")}
          value={terms.opens_ms}
          onValue={(opensMs) => onTerms({ opens_ms: opensMs })}
          problem={problemOf("opens_ms")}
        />
        <TimeField
          label={say("assignments.due")}
          hint={say("terms.empty_never")}
          value={terms.due_ms}
          onValue={(dueMs) => onTerms({ due_ms: dueMs })}
          problem={dueWrong ?? problemOf("due_ms")}
        />
        <NumberField
          label={say("terms.attempts_each")}
          hint={say("terms.zero_no_limit")}
          min={0}
          max={1000}
          value={terms.attempt_limit}
          onValue={(limit) => onTerms({ attempt_limit: limit })}
          problem={problemOf("attempt_limit")}
        />
        <SelectField<Counting>
          label={say("terms.counting")}
          value={terms.counting}
          onValue={(counting) => onTerms({ counting })}
          options={kCountings.map((counting) => ({ value: counting, title: countingText(counting) }))}
        />
      </div>
      <SelectField
        label={say("assignments.devices")}
        hint={say("terms.devices_hint")}
        value={terms.hands}
        onValue={(hands) => onTerms({ hands })}
        options={kHands.map((hands) => ({ value: hands, title: handsText({ hands }) }))}
        problem={problemOf("hands")}
      />
      <SelectField
        label={say("terms.outline")}
        hint={say("terms.outline_hint")}
        value={terms.outline}
        onValue={(outline) => onTerms({ outline })}
        options={kOutlines.map((outline) => ({ value: outline, title: outlineText({ outline }) }))}
        problem={problemOf("outline")}
      />
      <CheckField
        label={say("terms.late")}
        hint={say("terms.late_hint")}
        value={terms.late_allowed}
        onValue={(late) => onTerms({ late_allowed: late })}
      />
      <CheckField
        label={say("attempt_flag.exam")}
        hint={say("terms.exam_hint")}
        value={terms.exam}
        onValue={(exam) => onTerms({ exam })}
      />
      {terms.exam && (
        <CheckField
          label={say("terms.sign_off")}
          hint={say("terms.sign_off_hint")}
          value={terms.sign_off}
          onValue={(signOff) => onTerms({ sign_off: signOff })}
        />
      )}
      {terms.exam && stations.length > 0 && (
        <fieldset class="group">
          <legend>{say("terms.stations")}</legend>
          <p class="hint">{say("terms.any_station")}</p>
          <div class="check-list">
            {stations.map((station) => (
              <CheckField
                key={station.id}
                label={station.name}
                value={chosen.has(station.id)}
                onValue={(on) => toggle(station.id, on)}
              />
            ))}
          </div>
        </fieldset>
      )}
    </>
  );
}
