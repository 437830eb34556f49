import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { Appeal, AttemptDetail } from "../../api/types";
import { useChange } from "../../api/use_change";
import { unreachable } from "../../base/assert";
import { formatDateTime } from "../../base/format";
import { say } from "../../base/words";
import { Badge, Card, ErrorNotice } from "../../widgets/basics";
import { Button, needed } from "../../widgets/button";
import { LongTextField } from "../../widgets/form";
import { useDraft } from "../../widgets/use_draft";
import type { Rescore } from "./use_rescore";

const kMaxText = 4000;

interface Props {
  readonly client: Client;
  readonly attempt: AttemptDetail;
  readonly onChanged: () => void;
}

interface AnswerProps extends Props {
  readonly rescore: Rescore;
}

// A student's one appeal against a released score, and its answer.
export function AppealPanel({ client, attempt, rescore, onChanged }: AnswerProps) {
  const { appeal } = attempt;
  if (appeal === null)
    return !attempt.may.includes("appeal") ? null : (
      <FileAppeal client={client} attempt={attempt} onChanged={onChanged} />
    );
  return (
    <Card title={say("appeal.title")} aside={<AppealBadge state={appeal.state} />} className="appeal-card">
      <p class="hint">
        {attempt.person.display_name}, {formatDateTime(appeal.filed_ms)}
      </p>
      <blockquote class="quote">{appeal.text}</blockquote>
      {appeal.state !== "open" && (
        <>
          <p class="hint">{say("appeal.answered", { when: formatDateTime(appeal.answered_ms) })}</p>
          <blockquote class="quote">{appeal.answer}</blockquote>
        </>
      )}
      {appeal.state === "open" &&
        (attempt.may.includes("answer_appeal") ? (
          <AnswerAppeal client={client} attempt={attempt} rescore={rescore} onChanged={onChanged} />
        ) : (
          <p>{say("appeal.will_answer")}</p>
        ))}
    </Card>
  );
}

export function AppealBadge({ state }: { readonly state: Appeal["state"] }) {
  switch (state) {
    case "open":
      return <Badge tone="warning">{say("appeal.open")}</Badge>;
    case "regraded":
      return <Badge tone="good">{say("appeal.regraded")}</Badge>;
    case "rejected":
      return <Badge tone="neutral">{say("appeal.rejected")}</Badge>;
    default:
      return unreachable(state);
  }
}

function FileAppeal({ client, attempt, onChanged }: Props) {
  const [open, setOpen] = useState(false);
  const [text, setText, forget] = useDraft(`appeal ${attempt.id}`);
  const change = useChange();
  const submit = async (event: Event) => {
    event.preventDefault();
    const result = await change.run(() =>
      client.post("/attempts/{id}/appeal", { id: attempt.id, body: { text: text.trim() } }),
    );
    if (result?.ok !== true) return;
    forget();
    onChanged();
  };
  return (
    <Card title={say("appeal.wrong")} className="appeal-card no-print">
      {!open && (
        <button type="button" class="button" onClick={() => setOpen(true)}>
          {say("appeal.ask")}
        </button>
      )}
      {open && (
        <form class="form" onSubmit={(event) => void submit(event)}>
          <LongTextField
            label={say("appeal.what")}
            value={text}
            onValue={setText}
            required
            maxLength={kMaxText}
            hint={say("appeal.once")}
          />
          {change.error !== undefined && <ErrorNotice title={say("common.not_sent")} message={change.error.message} />}
          <div class="button-row">
            <Button busy={change.busy} blocked={needed({ [say("appeal.what")]: text.trim() })}>
              {say("appeal.send")}
            </Button>
            <button type="button" class="button" onClick={() => setOpen(false)}>
              {say("common.cancel")}
            </button>
          </div>
        </form>
      )}
    </Card>
  );
}

function AnswerAppeal({ client, attempt, rescore, onChanged }: AnswerProps) {
  const [text, setText, forget] = useDraft(`answer ${attempt.id}`);
  const change = useChange();
  const answer = async (outcome: "regrade" | "reject") => {
    const send = () =>
      client.post("/attempts/{id}/appeal/answer", { id: attempt.id, body: { outcome, answer: text.trim() } });
    const result = await change.run(() => (outcome === "regrade" ? rescore.ask(send) : send()));
    if (result?.ok !== true) return;
    forget();
    onChanged();
  };
  const wanted = needed({ [say("appeal.your_answer")]: text.trim() });
  return (
    <form class="form" onSubmit={(event) => event.preventDefault()}>
      <LongTextField
        label={say("appeal.your_answer")}
        hint={say("appeal.student_reads")}
        value={text}
        onValue={setText}
        required
        maxLength={kMaxText}
      />
      {change.error !== undefined && <ErrorNotice title={say("appeal.not_answered")} message={change.error.message} />}
      <div class="button-row">
        <Button busy={change.busy} blocked={wanted} tip="" onClick={() => void answer("regrade")}>
          {say("appeal.answer_regrade")}
        </Button>
        <Button kind="" busy={change.busy} blocked={wanted} onClick={() => void answer("reject")}>
          {say("appeal.reject")}
        </Button>
      </div>
      <p class="hint">{say("appeal.regrade_hint")}</p>
    </form>
  );
}
