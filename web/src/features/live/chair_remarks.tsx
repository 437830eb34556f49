import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import { useSavedTexts, withText } from "../../api/saved_texts";
import type { LiveRemark, LiveRemarks } from "../../api/types";
import { useChange } from "../../api/use_change";
import { useRefresh } from "../../api/use_refresh";
import { useRequest } from "../../api/use_request";
import { formatDuration } from "../../base/format";
import { say } from "../../base/words";
import { Badge, Card, ErrorNotice, Notice } from "../../widgets/basics";
import { Button, needed } from "../../widgets/button";
import { TextField } from "../../widgets/form";
import { SavedTextList, SaveText } from "../../widgets/saved_texts";

const kPollMs = 2000;

// A line of text for the person at the station, and the delivery state of each.
export function ChairRemarks({
  client,
  attempt,
  rateHz,
}: {
  readonly client: Client;
  readonly attempt: string;
  readonly rateHz: number;
}) {
  const { loaded, reload } = useRequest(attempt, (signal) => client.get("/live/{id}/remarks", { id: attempt, signal }));
  useRefresh(true, kPollMs, reload);
  return (
    <Card title={say("chair.title")}>
      {loaded.state === "failed" && (
        <ErrorNotice title={say("chair.failed")} message={loaded.error.message} onRetry={reload} />
      )}
      {loaded.state === "ready" && (
        <>
          <Speak client={client} attempt={attempt} state={loaded.value} onSent={reload} />
          <ul class="annotations" aria-label={say("chair.said")}>
            {[...loaded.value.remarks].reverse().map((remark) => (
              <li key={remark.id}>
                <Said remark={remark} rateHz={rateHz} />
              </li>
            ))}
          </ul>
        </>
      )}
    </Card>
  );
}

function Speak({
  client,
  attempt,
  state,
  onSent,
}: {
  readonly client: Client;
  readonly attempt: string;
  readonly state: LiveRemarks;
  readonly onSent: () => void;
}) {
  const [text, setText] = useState("");
  const saved = useSavedTexts(client);
  const change = useChange();
  const why = whyNot(state);
  if (why !== undefined && text === "")
    return (
      <Notice tone="neutral">
        <p>{why}</p>
      </Notice>
    );
  const send = async () => {
    const sent = await change.run(() => client.post("/live/{id}/remarks", { id: attempt, body: { text } }));
    if (sent?.ok !== true) return;
    setText("");
    onSent();
  };
  return (
    <form
      class="form"
      onSubmit={(event) => {
        event.preventDefault();
        void send();
      }}
    >
      <TextField
        label={say("chair.remark")}
        hint={say("chair.hint")}
        value={text}
        onValue={setText}
        required
        maxLength={state.max_characters}
        problem={change.error?.message}
      />
      <div class="button-row">
        <Button busy={change.busy} blocked={why ?? needed({ [say("chair.remark")]: text.trim() })}>
          {say("chair.send")}
        </Button>
        <SaveText saved={saved} text={text} />
      </div>
      <SavedTextList saved={saved} onUse={(words) => setText(withText(text, words))} />
    </form>
  );
}

function whyNot({ allowed, station }: LiveRemarks): string | undefined {
  if (!allowed) return say("chair.exam");
  if (!station.connected) return say("chair.not_connected");
  return station.shows_remarks ? undefined : say("chair.too_old");
}

function Said({ remark, rateHz }: { readonly remark: LiveRemark; readonly rateHz: number }) {
  return (
    <>
      <p>{remark.text}</p>
      <p class="byline">
        <State remark={remark} />{" "}
        {say("chair.from", { from: remark.from, moment: formatDuration(remark.tick / rateHz) })}
      </p>
    </>
  );
}

function State({ remark }: { readonly remark: LiveRemark }) {
  switch (remark.state) {
    case "waiting":
      return <Badge tone="neutral">{say("chair.waiting")}</Badge>;
    case "sent":
      return <Badge tone="neutral">{say("chair.sent")}</Badge>;
    case "shown":
      return <Badge tone="good">{say("chair.shown")}</Badge>;
  }
}
