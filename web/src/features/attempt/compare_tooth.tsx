import { useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { Attempt, AttemptDetail } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { formatDateTime, formatScore } from "../../base/format";
import { say } from "../../base/words";
import { part } from "../../widgets/part";

const kMaxOwn = 200;
const kMaxOthers = 50;
const kSearch = "search"; // the choice that opens the search

const Search = part("compare_search", () => import("./compare_search"));

interface ChoiceProps {
  readonly client: Client;
  readonly attempt: AttemptDetail;
  readonly staff: boolean;
  readonly chosen: string | undefined;
  readonly onChoose: (id: string | undefined, name: string) => void;
}

// The attempt that this one is compared with: the reference, another one of the same person, or of
// somebody else's whom one may see.
export function CompareChoice({ client, attempt, staff, chosen, onChoose }: ChoiceProps) {
  const [asked, setAsked] = useState(false); // the list is fetched when somebody wants it
  const exercise = attempt.exercise.id;
  // The person's own are asked for by themselves: in a large class none of them is among the newest.
  const mine = useRequest(asked ? `${exercise} ${attempt.person.id}` : undefined, (signal) =>
    client.page("/attempts", { exercise, person: attempt.person.id, state: "scored", limit: kMaxOwn, signal }),
  );
  const { loaded } = useRequest(asked && staff ? exercise : undefined, (signal) =>
    client.page("/attempts", { exercise, state: "scored", limit: kMaxOthers, signal }),
  );
  const own = mine.loaded.state === "ready" ? mine.loaded.value.items.filter(({ id }) => id !== attempt.id) : [];
  const others =
    loaded.state === "ready" ? loaded.value.items.filter(({ person }) => person.id !== attempt.person.id) : [];
  const [searching, setSearching] = useState(false);
  const [found, setFound] = useState<Attempt>(); // by searching; neither the person's own nor among the newest
  const listed = [...own, ...others];
  if (found !== undefined && !listed.some(({ id }) => id === found.id))
    (found.person.id === attempt.person.id ? own : others).unshift(found);
  const reference = comparable(attempt, staff);
  const choose = (select: HTMLSelectElement) => {
    if (select.value !== kSearch) {
      onChoose(select.value || undefined, select.selectedOptions[0]?.title ?? "");
      return;
    }
    select.value = chosen ?? "";
    setSearching(true);
  };
  const search = (
    <Search
      show={({ CompareSearch }) => (
        <CompareSearch
          client={client}
          attempt={attempt}
          onClose={() => setSearching(false)}
          onFound={(other) => {
            setFound(other);
            setSearching(false);
            onChoose(other.id, attemptName(other));
          }}
        />
      )}
    />
  );
  return (
    <>
      <select
        aria-label={say("compare.with")}
        value={chosen ?? ""}
        onFocus={() => setAsked(true)}
        onPointerDown={() => setAsked(true)}
        onChange={({ currentTarget }) => choose(currentTarget)}
      >
        <option value="">{say("compare.nothing")}</option>
        {reference !== undefined && (
          <option value={reference.attempt_id} title={referenceName(reference)}>
            {referenceName(reference)}
          </option>
        )}
        {own.length > 0 && (
          <optgroup label={say("compare.same_person")}>
            {own.map((other) => (
              <option key={other.id} value={other.id} title={attemptName(other)}>
                {title(other)}
              </option>
            ))}
          </optgroup>
        )}
        {others.length > 0 && (
          <optgroup label={say("compare.others")}>
            {others.map((other) => (
              <option key={other.id} value={other.id} title={attemptName(other)}>
                {attemptName(other)}
              </option>
            ))}
          </optgroup>
        )}
        {asked && (mine.loaded.state === "loading" || (staff && loaded.state === "loading")) && (
          <option disabled>{say("loading.short")}</option>
        )}
        {staff && <option value={kSearch}>{say("compare.search")}</option>}
      </select>
      {searching && search}
    </>
  );
}

// Students are offered it with the dentist's consent: only then does the answer name the dentist.
type Reference = NonNullable<AttemptDetail["reference"]>;
export function comparable({ id, reference }: AttemptDetail, staff: boolean): Reference | undefined {
  if (reference === null || reference.attempt_id === id) return undefined;
  return staff || reference.dentist !== null ? reference : undefined;
}

const title = (attempt: Attempt) =>
  `${formatDateTime(attempt.ticketed_ms)}${attempt.score === null ? "" : `, ${formatScore(attempt.score)}`}`;

// Whose it is, when, and its score.
export function attemptName(attempt: Attempt): string {
  return `${attempt.person.display_name}, ${title(attempt)}`;
}

export function referenceName({ dentist }: Reference): string {
  return dentist === null ? say("compare.reference") : say("compare.reference_of", { dentist });
}
