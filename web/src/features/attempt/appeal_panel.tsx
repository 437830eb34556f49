import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { Appeal, AttemptDetail } from "../../api/types";
import { useChange } from "../../api/use_change";
import { unreachable } from "../../base/assert";
import { formatDateTime } from "../../base/format";
import { Badge, Card, ErrorNotice } from "../../widgets/basics";
import { LongTextField } from "../../widgets/form";

const kMaxText = 4000;

interface Props {
  readonly client: Client;
  readonly attempt: AttemptDetail;
  readonly onChanged: () => void;
}

// A student's one appeal against a released score, and its answer.
export function AppealPanel({ client, attempt, onChanged }: Props) {
  const { appeal } = attempt;
  if (appeal === null) return !attempt.may.includes("appeal") ? null : <FileAppeal client={client} attempt={attempt} onChanged={onChanged} />;
  return (
    <Card title="Appeal" aside={<AppealBadge state={appeal.state} />} className="appeal-card">
      <p class="hint">{attempt.person.display_name}, {formatDateTime(appeal.filed_ms)}</p>
      <blockquote class="quote">{appeal.text}</blockquote>
      {appeal.state !== "open" && (
        <>
          <p class="hint">Answered {formatDateTime(appeal.answered_ms)}</p>
          <blockquote class="quote">{appeal.answer}</blockquote>
        </>
      )}
      {appeal.state === "open" && (attempt.may.includes("answer_appeal") ? <AnswerAppeal client={client} attempt={attempt} onChanged={onChanged} />
        : <p>An instructor of the cohort will answer here.</p>)}
    </Card>
  );
}

export function AppealBadge({ state }: { readonly state: Appeal["state"] }) {
  switch (state) {
    case "open": return <Badge tone="warning">Not answered yet</Badge>;
    case "regraded": return <Badge tone="good">Graded again</Badge>;
    case "rejected": return <Badge tone="neutral">Rejected</Badge>;
    default: return unreachable(state);
  }
}

function FileAppeal({ client, attempt, onChanged }: Props) {
  const [open, setOpen] = useState(false);
  const [text, setText] = useState("");
  const change = useChange();
  const submit = async (event: Event) => {
    event.preventDefault();
    const result = await change.run(() => client.teaching.fileAppeal(attempt.id, text.trim()));
    if (result?.ok === true) onChanged();
  };
  return (
    <Card title="Something wrong with this score?" className="appeal-card no-print">
      {!open && <button type="button" class="button" onClick={() => setOpen(true)}>Appeal against the score…</button>}
      {open && (
        <form class="form" onSubmit={(event) => void submit(event)}>
          <LongTextField label="What should be looked at again, and why" value={text} onValue={setText} required maxLength={kMaxText}
                         hint="You can appeal once per attempt. Your instructor may have it graded again, which can raise or lower the score." />
          {change.error !== undefined && <ErrorNotice title="Not sent" message={change.error.message} />}
          <div class="button-row">
            <button type="submit" class="button primary" disabled={change.busy || text.trim() === ""}>Send the appeal</button>
            <button type="button" class="button" onClick={() => setOpen(false)}>Cancel</button>
          </div>
        </form>
      )}
    </Card>
  );
}

function AnswerAppeal({ client, attempt, onChanged }: Props) {
  const [text, setText] = useState("");
  const change = useChange();
  const answer = async (outcome: "regrade" | "reject") => {
    const result = await change.run(() => client.teaching.answerAppeal(attempt.id, outcome, text.trim()));
    if (result?.ok === true) onChanged();
  };
  return (
    <form class="form" onSubmit={(event) => event.preventDefault()}>
      <LongTextField label="Your answer" hint="The student reads it." value={text} onValue={setText} required maxLength={kMaxText} />
      {change.error !== undefined && <ErrorNotice title="Not answered" message={change.error.message} />}
      <div class="button-row">
        <button type="button" class="button primary" disabled={change.busy || text.trim() === ""} onClick={() => void answer("regrade")}>Answer and grade again</button>
        <button type="button" class="button" disabled={change.busy || text.trim() === ""} onClick={() => void answer("reject")}>Reject the appeal</button>
      </div>
      <p class="hint">Grading again replays the recording against the newest reference; both results stay visible. If the score changes, the student sees it once you release it again. To set a score yourself, use “Set another score” above.</p>
    </form>
  );
}
