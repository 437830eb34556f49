import { useState } from "preact/hooks";
import { exerciseTitle } from "../../api/builtin_words";
import type { Client } from "../../api/client";
import type { Attempt, AttemptDetail } from "../../api/types";
import { usePages } from "../../api/use_pages";
import { useRequest } from "../../api/use_request";
import { useSettled } from "../../api/use_settled";
import { formatDateTime, formatScore } from "../../base/format";
import { say } from "../../base/words";
import { Brief } from "../../widgets/basics";
import { Dialog } from "../../widgets/dialog";
import { SelectField, TextField } from "../../widgets/form";
import { PagedList } from "../../widgets/pages";
import { DataTable } from "../../widgets/table";

const kPageSize = 20;
const kTypingMs = 250; // after which somebody has finished typing

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
  const name = useSettled(text, kTypingMs);
  const exercises = useRequest("exercises", (signal) => client.teaching.exercises(undefined, signal));
  const known = exercises.loaded.state === "ready" ? exercises.loaded.value : [];
  const pages = usePages(`${exercise} ${name}`, (cursor, signal) =>
    client.attempts({ exercise, name, state: "scored", cursor, limit: kPageSize }, signal),
  );
  return (
    <Dialog title={say("compare.search_title")} onClose={onClose} wide>
      <div class="filters" role="search">
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
      </div>
      <PagedList pages={pages} list="attempts" empty={say(name === "" ? "attempts.none" : "common.nobody_named")}>
        {(attempts) => (
          <DataTable
            label={say("nav.attempts")}
            items={attempts.filter(({ id }) => id !== attempt.id)}
            rowKey={({ id }) => id}
            dense
            columns={[
              { title: say("common.student"), cell: (found) => found.person.display_name },
              { title: say("common.when"), cell: (found) => formatDateTime(found.ticketed_ms) },
              { title: say("common.score"), number: true, cell: (found) => formatScore(found.score) },
              {
                title: say("compare.choose"),
                hideTitle: true,
                cell: (found) => (
                  <button type="button" class="button small" onClick={() => onFound(found)}>
                    <Brief
                      shown={say("compare.choose")}
                      full={say("compare.choose_which", {
                        name: found.person.display_name,
                        when: formatDateTime(found.ticketed_ms),
                      })}
                    />
                  </button>
                ),
              },
            ]}
          />
        )}
      </PagedList>
      <div class="button-row end">
        <button type="button" class="button" onClick={onClose}>
          {say("common.cancel")}
        </button>
      </div>
    </Dialog>
  );
}
