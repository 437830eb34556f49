import { useMemo, useRef, useState } from "preact/hooks";
import { exerciseTitle } from "../../api/builtin_words";
import type { Client } from "../../api/client";
import { anatomyOf } from "../../api/tooth_number";
import type { Marking } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { formatDateTime } from "../../base/format";
import { say } from "../../base/words";
import { Card, Notice, PageTitle, Waits } from "../../widgets/basics";
import { Button } from "../../widgets/button";
import { KeysHelp, useKeys } from "../../widgets/keys";
import { progressText } from "./how_far";
import { nextOf, type Rating } from "./mark";
import { kRatings, MarkForm, ratingTitle } from "./mark_form";
import { MarkingResultsView } from "./marking_results";
import { WorkTooth } from "./work_tooth";

// A blind marking: the caller's work one by one, and, once everybody has marked everything, what came of it.
export function MarkingPage({ client, id }: { readonly client: Client; readonly id: string }) {
  const { loaded, reload } = useRequest(id, (signal) => client.get("/markings/{id}", { id, signal }));
  if (loaded.state !== "ready")
    return (
      <Waits loaded={loaded} reload={reload} what={say("loading.marking")} failed={say("marking.failed")}>
        <PageTitle document={say("marking.title")}>{say("marking.title")}</PageTitle>
      </Waits>
    );
  const marking = loaded.value;
  const title = say("marking.of", { exercise: exerciseTitle(marking.exercise) });
  return (
    <>
      <nav class="trail" aria-label={say("common.where")}>
        <a href={`/assignments/${marking.assignment_id}`}>{exerciseTitle(marking.exercise)}</a>
      </nav>
      <PageTitle document={title}>{title}</PageTitle>
      <p class="byline">
        {say("marking.begun", { when: formatDateTime(marking.created_ms) })}
        {" · "}
        {marking.markers.map((marker) => progressText(marker, marking.works)).join(" · ")}
      </p>
      {marking.results !== null ? (
        <MarkingResultsView marking={marking} results={marking.results} />
      ) : marking.ended_ms > 0 ? (
        <Notice tone="neutral" title={say("marking.given_up")}>
          <p>{say("marking.given_up_text", { when: formatDateTime(marking.ended_ms) })}</p>
        </Notice>
      ) : (
        <MyWork client={client} marking={marking} onMarked={reload} />
      )}
    </>
  );
}

function MyWork({
  client,
  marking,
  onMarked,
}: {
  readonly client: Client;
  readonly marking: Marking;
  readonly onMarked: () => void;
}) {
  const { mine, exercise } = marking;
  const [chosen, setChosen] = useState<string>();
  const work = chosen ?? nextOf(mine, undefined);
  const at = mine.findIndex(({ id }) => id === work);
  const rate = useRef<((rating: Rating) => void) | undefined>(undefined);
  const go = (by: 1 | -1) => {
    const waiting = mine.filter(({ marked, id }) => !marked || id === work);
    const place = waiting.findIndex(({ id }) => id === work);
    setChosen(waiting[(place + by + waiting.length) % waiting.length]?.id);
  };
  const keys = useKeys([
    ...kRatings.map((rating) => ({
      key: String(rating),
      what: ratingTitle(rating),
      act: () => rate.current?.(rating),
    })),
    { key: "n", what: say("marking.next"), act: () => go(1) },
    { key: "p", what: say("marking.previous"), act: () => go(-1) },
  ]);
  const details = useRequest(mine.length === 0 ? undefined : exercise.id, (signal) =>
    client.tagged("GET", "/exercises/{id}", { id: exercise.id, signal }),
  );
  const target = details.loaded.state === "ready" ? details.loaded.value.value.target : undefined;
  const anatomy = useMemo(() => (target === undefined ? undefined : anatomyOf(target)), [target]);
  if (mine.length === 0)
    return (
      <Notice tone="neutral" title={say("marking.under_way")}>
        <p>{say("marking.not_yours")}</p>
      </Notice>
    );
  if (work === undefined || mine[at]?.marked !== false)
    return (
      <Notice tone="good" title={say("marking.all_mine")}>
        <p>{say("marking.wait_for_others")}</p>
        <button type="button" class="button small" onClick={onMarked}>
          {say("marking.look_again")}
        </button>
      </Notice>
    );
  const name = say("marking.work", { number: String(at + 1) });
  return (
    <>
      <p class="hint">{say("marking.blind")}</p>
      <div class="button-row works" role="group" aria-label={say("marking.works")}>
        {mine.map(({ id, marked }, i) => (
          <Button
            key={id}
            kind="small"
            blocked={marked ? say("marking.work_marked", { number: String(i + 1) }) : undefined}
            tip={say("marking.work", { number: String(i + 1) })}
            aria-pressed={id === work}
            aria-label={say("marking.work", { number: String(i + 1) })}
            onClick={() => setChosen(id)}
          >
            {marked ? "✓" : i + 1}
          </Button>
        ))}
      </div>
      <div class="columns marking">
        <Card title={name} className="tooth-card">
          <WorkTooth key={work} client={client} work={work} name={name} anatomy={anatomy} />
        </Card>
        <Card title={say("marking.mark")}>
          <MarkForm
            key={work}
            client={client}
            work={work}
            marking={marking}
            onRate={(act) => {
              rate.current = act;
            }}
            onSent={() => {
              setChosen(nextOf(mine, work));
              onMarked();
            }}
          />
        </Card>
      </div>
      <KeysHelp keys={keys} />
    </>
  );
}
