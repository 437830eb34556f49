import { useMemo } from "preact/hooks";
import { exerciseTitle } from "../../api/builtin_words";
import type { Client } from "../../api/client";
import { forceSize } from "../../api/live";
import type { Attempt, Exercise } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { useRefresh } from "../../api/use_refresh";
import { formatQuantity } from "../../base/format";
import { relativeTime } from "../../base/local_time";
import { ok } from "../../base/result";
import { say, sayWith } from "../../base/words";
import type { ToothPlan } from "../../tooth/messages";
import { Badge, Bar, Empty, PageTitle, Waits } from "../../widgets/basics";
import { ForceStrip } from "./force_strip";
import { liveTime, recentFaults } from "./live_time";
import type { Cut } from "./cut";
import { cutText, kFromAbove, ToolView, workpieceOf } from "./tool_view";
import { emptyTrack, kDefaultRateHz, type Track } from "./track";
import { useCuts } from "./use_cuts";
import { usePlans } from "./use_plans";
import { useTracks } from "./use_tracks";

const kPollMs = 5000;
const kMaxShown = 100;

// What is being made at the stations now, of the cohorts the caller may see.
export function LivePage({ client }: { readonly client: Client }) {
  const { loaded, reload } = useRequest("live", (signal) =>
    client.page("/attempts", { state: "recording", limit: kMaxShown, signal }),
  );
  useRefresh(true, kPollMs, reload);
  const attempts = loaded.state === "ready" ? loaded.value.items : [];
  const exercises = useExercises(client, attempts);
  const plans = usePlans(client, [...exercises.values()]);
  const tracks = useTracks(
    attempts.map((attempt) => ({
      id: attempt.id,
      rateHz: exercises.get(attempt.exercise.id)?.rate_hz ?? kDefaultRateHz,
    })),
    reload,
  );
  const cuts = useCuts(
    client,
    attempts.map(({ id }) => id),
  );
  return (
    <>
      <PageTitle document={say("nav.live")}>{say("nav.live")}</PageTitle>
      <Waits loaded={loaded} reload={reload} what={say("loading.live")} failed={say("live.failed")} />
      {loaded.state === "ready" &&
        (attempts.length === 0 ? (
          <Empty>{say("live.none")}</Empty>
        ) : (
          <ul class="card-list live-list">
            {attempts.map((attempt) => (
              <li key={attempt.id}>
                <LiveCard
                  attempt={attempt}
                  exercise={exercises.get(attempt.exercise.id)}
                  plan={plans.get(attempt.exercise.id)?.above}
                  track={tracks.get(attempt.id) ?? emptyTrack}
                  cut={cuts.get(attempt.id)}
                />
              </li>
            ))}
          </ul>
        ))}
      {attempts.length > 3 && <p class="hint">{say("live.three")}</p>}
    </>
  );
}

// How long each exercise may take. What is not known yet is left out, and so is what cannot be read: it is asked for
// again.
function useExercises(client: Client, attempts: readonly Attempt[]): ReadonlyMap<string, Exercise> {
  const ids = [...new Set(attempts.map((attempt) => attempt.exercise.id))].sort();
  const { loaded, reload } = useRequest(ids.length === 0 ? undefined : ids.join(" "), async (signal) => {
    const read = await Promise.all(ids.map((id) => client.tagged("GET", "/exercises/{id}", { id, signal })));
    return ok(
      new Map(read.flatMap((result) => (result.ok ? [[result.value.value.id, result.value.value] as const] : []))),
    );
  });
  useRefresh(loaded.state === "ready" && loaded.value.size < ids.length, kPollMs, reload);
  return loaded.state === "ready" ? loaded.value : kNone;
}

const kNone: ReadonlyMap<string, Exercise> = new Map();

interface CardProps {
  readonly attempt: Attempt;
  readonly exercise: Exercise | undefined;
  readonly plan: ToothPlan | undefined;
  readonly track: Track;
  readonly cut: Cut | undefined;
}

// Of forty cards a few change at a time: the others stay as they are.
function LiveCard({ attempt, exercise, plan, track, cut }: CardProps) {
  return useMemo(
    () => <CardNow attempt={attempt} exercise={exercise} plan={plan} track={track} cut={cut} />,
    [attempt, exercise, plan, track, cut],
  );
}

function CardNow({ attempt, exercise, plan, track, cut }: CardProps) {
  const workpiece = workpieceOf(exercise, plan, attempt, cut);
  const rateHz = exercise?.rate_hz ?? kDefaultRateHz;
  const time = liveTime(
    Math.max(attempt.ticks + attempt.gap_ticks, track.rows.at(-1)?.tick ?? 0),
    rateHz,
    exercise?.time_limit_s ?? 0,
  );
  return (
    <article class="card live-card">
      <div class="card-head">
        <h2>
          <a href={`/live/${attempt.id}`}>{attempt.station.name}</a>
        </h2>
        <LiveState track={track} />
      </div>
      <p>
        {attempt.person.display_name}
        <span class="hint"> · {exerciseTitle(attempt.exercise)}</span>
      </p>
      {exercise !== undefined && (
        <div class="live-time">
          <span>
            {time.text} {time.over && <Badge tone="warning">{say("attempt_flag.over_time")}</Badge>}
          </span>
          {time.share !== undefined && (
            <Bar share={time.share} tone={time.over ? "bad" : time.share > 0.9 ? "warning" : "good"} />
          )}
        </div>
      )}
      {track.rows.length === 0 ? (
        <p class="live-waiting hint">{track.state === "disturbed" ? track.problem : say("live.first_movement")}</p>
      ) : (
        <>
          <div class="live-pictures">
            <ToolView rows={track.rows} rateHz={rateHz} plane={kFromAbove} workpiece={workpiece} />
            <ForceStrip rows={track.rows} rateHz={rateHz} />
          </div>
          <ForceNow track={track} />
          <p class="hint">{cutText(workpiece)}</p>
        </>
      )}
    </article>
  );
}

export function ForceNow({ track }: { readonly track: Track }) {
  const last = track.rows.at(-1);
  return (
    <p class="live-force">
      {sayWith("live.force_now", { force: <b>{last === undefined ? "–" : formatQuantity(forceSize(last), "N")}</b> })}{" "}
      {recentFaults(track).map((text) => (
        <Badge key={text} tone="warning">
          {text}
        </Badge>
      ))}
    </p>
  );
}

export function LiveState({ track }: { readonly track: Track }) {
  switch (track.state) {
    case "waiting":
      return <Badge tone="neutral">{say("live.waiting")}</Badge>;
    case "live":
      return (
        <Badge tone="good">
          {Date.now() - track.heardMs < 4000
            ? say("live.live")
            : say("live.seen", { when: relativeTime(track.heardMs, Date.now()) })}
        </Badge>
      );
    case "ended":
      return <Badge tone="neutral">{say("live.finished")}</Badge>;
    case "disturbed":
      return <Badge tone="warning">{say("live.no_picture")}</Badge>;
  }
}
