import { useId, useLayoutEffect } from "preact/hooks";
import type { Client } from "../../api/client";
import type { Marking } from "../../api/types";
import { useChange } from "../../api/use_change";
import { criterionTitle } from "../../api/worded";
import { formatPoints, formatScore } from "../../base/format";
import { say, sayIf } from "../../base/words";
import { ErrorNotice } from "../../widgets/basics";
import { Button } from "../../widgets/button";
import { DataTable } from "../../widgets/table";
import { useDraft } from "../../widgets/use_draft";
import {
  complete,
  draftFrom,
  filled,
  kNoMark,
  type MarkDraft,
  missing,
  type Rating,
  shownPoints,
  totalOf,
} from "./mark";

export const kRatings: readonly Rating[] = [1, 2, 3, 4, 5];
const kMaxComment = 500;

export function ratingTitle(rating: Rating): string {
  return say(`marking.rating_${rating}`);
}

interface Props {
  readonly client: Client;
  readonly work: string;
  readonly marking: Marking;
  readonly onSent: () => void;
  // What the page's number keys call.
  readonly onRate: (rate: (rating: Rating) => void) => void;
}

// The rating of the whole comes first, before any points are seen: it is what a pass mark is computed from.
export function MarkForm({ client, work, marking: { criteria, comments }, onSent, onRate }: Props) {
  const [text, put, forget] = useDraft(`mark ${work}`);
  const draft = text === "" ? kNoMark : draftFrom(text);
  const set = (change: Partial<MarkDraft>) => put(JSON.stringify({ ...draft, ...change }));
  const change = useChange();
  const list = useId();
  const rate = (rating: Rating) => set({ rating });
  useLayoutEffect(() => onRate(rate)); // before a key can come for this work
  const ready = complete(draft, criteria);
  const left = missing(draft, criteria);
  const send = async (event: Event) => {
    event.preventDefault();
    if (ready === undefined) return;
    const result = await change.run(() =>
      client.post("/marking-works/{id}/marks", { id: work, body: { rating: ready.rating, criteria: ready.criteria } }),
    );
    if (result?.ok !== true) return;
    forget();
    onSent();
  };
  return (
    <form class="mark-form" onSubmit={(event) => void send(event)}>
      <fieldset class="ratings">
        <legend>{say("marking.whole")}</legend>
        {kRatings.map((rating) => (
          <label key={rating}>
            <input
              type="radio"
              name={`rating-${work}`}
              checked={draft.rating === rating}
              onChange={() => rate(rating)}
            />
            <span>
              <span class="key" aria-hidden="true">
                {rating}
              </span>{" "}
              {ratingTitle(rating)}
            </span>
          </label>
        ))}
      </fieldset>
      {draft.rating !== undefined && (
        <>
          <DataTable
            label={say("marking.criteria")}
            items={criteria}
            rowKey={({ name }) => name}
            columns={[
              {
                title: say("marking.criterion"),
                cell: (criterion) => (
                  <>
                    {criterionTitle(criterion)}
                    <span class="sub">{sayIf(`marking_group.${criterion.name}`)}</span>
                  </>
                ),
              },
              {
                title: say("marking.points"),
                cell: ({ name, title, max_points: most }) => (
                  <span class="mark-points">
                    <input
                      type="number"
                      min={0}
                      max={most}
                      step="any"
                      required
                      aria-label={say("marking.points_for", { title: criterionTitle({ name, title }) })}
                      value={shownPoints(draft.points[name])}
                      onInput={(event) =>
                        set({ points: { ...draft.points, [name]: event.currentTarget.valueAsNumber } })
                      }
                    />
                    <span>{say("marking.of_points", { most: formatPoints(most) })}</span>
                  </span>
                ),
              },
              {
                title: say("marking.comment"),
                cell: ({ name, title }) => (
                  <>
                    <input
                      type="text"
                      maxLength={kMaxComment}
                      list={`${list}${name}`}
                      autocomplete="off"
                      aria-label={say("marking.comment_on", { title: criterionTitle({ name, title }) })}
                      value={draft.comments[name] ?? ""}
                      onInput={(event) => set({ comments: { ...draft.comments, [name]: event.currentTarget.value } })}
                    />
                    <datalist id={`${list}${name}`}>
                      {comments
                        .filter((said) => said.name === name)
                        .map((said) => (
                          <option key={said.comment} value={said.comment} />
                        ))}
                    </datalist>
                  </>
                ),
              },
            ]}
          />
          <div class="button-row">
            <Button
              kind="small"
              blocked={left.length === 0 ? say("marking.all_given") : undefined}
              onClick={() => put(JSON.stringify(filled(draft, criteria)))}
            >
              {say("marking.fill")}
            </Button>
            <span class="mark-total">{say("marking.total", { total: formatScore(totalOf(draft, criteria)) })}</span>
          </div>
        </>
      )}
      {change.error !== undefined && <ErrorNotice title={say("marking.not_sent")} message={change.error.message} />}
      <div class="button-row">
        <Button
          busy={change.busy}
          blocked={
            draft.rating === undefined
              ? say("marking.rating_first")
              : left.length > 0
                ? say("marking.left", { count: left.length })
                : undefined
          }
        >
          {say("marking.send")}
        </Button>
        {ready !== undefined && <span class="hint">{say("marking.once")}</span>}
      </div>
    </form>
  );
}
