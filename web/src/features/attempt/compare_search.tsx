import { useState } from "preact/hooks";
import { exerciseTitle } from "../../api/builtin_words";
import type { Client } from "../../api/client";
import type { Attempt, AttemptDetail } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { formatDateTime, formatScore } from "../../base/format";
import { say } from "../../base/words";
import { Brief, Empty, Waits } from "../../widgets/basics";
import { Dialog } from "../../widgets/dialog";
import { SelectField, TextField } from "../../widgets/form";
import { DataTable } from "../../widgets/table";

const kMost = 50;

interface Props {
  readonly client: Client;
  readonly attempt: AttemptDetail;
  readonly onFound: (attempt: Attempt) => void;
  readonly onClose: () => void;
}

// Any scored attempt to compare with, by its person and its exercise: the server searches all of them.
export function CompareSearch({ client, attempt, onFound, onClose }: Props) {
  const [text, setText] = useState("");
  const [exercise, setExercise] = useState(attempt.exercise.id);
  const [name, setName] = useState(""); // that is searched
  const exercises = useRequest("exercises", (signal) => client.all("/exercises", { signal }));
  const known = exercises.loaded.state === "ready" ? exercises.loaded.value : [];
  const { loaded, reload } = useRequest(`${exercise} ${name}`, (signal) =>
    client.page("/attempts", { exercise, name, state: "scored", limit: kMost, signal }),
  );
  const found = loaded.state === "ready" ? loaded.value.items.filter(({ id }) => id !== attempt.id) : [];
  return (
    <Dialog title={say("compare.search_title")} onClose={onClose} wide>
      <form
        class="filters"
        role="search"
        onSubmit={(event) => {
          event.preventDefault();
          setName(text);
        }}
      >
        <TextField label={say("common.student")} value={text} onValue={setText} maxLength={100} />
        <SelectField
          label={say("common.exercise")}
          value={exercise}
          onValue={setExercise}
          options={(known.some(({ id }) => id === exercise) ? known : [attempt.exercise, ...known]).map((each) => ({
            value: each.id,
            title: exerciseTitle(each),
          }))}
        />
        <button type="submit" class="button">
          {say("people.search")}
        </button>
      </form>
      <Waits loaded={loaded} reload={reload} what={say("loading.attempts")} failed={say("list_failed.attempts")} />
      {loaded.state === "ready" &&
        (found.length === 0 ? (
          <Empty>{say(name === "" ? "attempts.none" : "common.nobody_named")}</Empty>
        ) : (
          <DataTable
            label={say("nav.attempts")}
            items={found}
            rowKey={({ id }) => id}
            dense
            columns={[
              { title: say("common.student"), cell: (other) => other.person.display_name },
              { title: say("common.when"), cell: (other) => formatDateTime(other.ticketed_ms) },
              { title: say("common.score"), number: true, cell: (other) => formatScore(other.score) },
              {
                title: say("compare.choose"),
                hideTitle: true,
                cell: (other) => (
                  <button type="button" class="button small" onClick={() => onFound(other)}>
                    <Brief
                      shown={say("compare.choose")}
                      full={say("compare.choose_which", {
                        name: other.person.display_name,
                        when: formatDateTime(other.ticketed_ms),
                      })}
                    />
                  </button>
                ),
              },
            ]}
          />
        ))}
      {loaded.state === "ready" && loaded.value.next !== null && (
        <p class="hint">{say("grading.more", { count: kMost })}</p>
      )}
      <div class="button-row end">
        <button type="button" class="button" onClick={onClose}>
          {say("common.cancel")}
        </button>
      </div>
    </Dialog>
  );
}
