import { exerciseTitle, wordedTitle } from "../../api/builtin_words";
import type { Client } from "../../api/client";
import type { AttemptDetail } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { useRefresh } from "../../api/use_refresh";
import { formatDuration, formatNumber } from "../../base/format";
import { say } from "../../base/words";
import { Card, Empty, Notice, PageTitle, Waits } from "../../widgets/basics";
import { ForceNow, LiveState } from "./live_page";
import { ChairRemarks } from "./chair_remarks";
import { ForceStrip } from "./force_strip";
import { cutText, kFromAbove, kFromSide, ToolView, workpieceOf } from "./tool_view";
import { emptyTrack, kDefaultRateHz, kTrackSeconds, largestForce } from "./track";
import { useCuts } from "./use_cuts";
import { usePlans } from "./use_plans";
import { useTracks } from "./use_tracks";

const kPollMs = 5000;

// One attempt in progress.
export function WatchPage({ client, id }: { readonly client: Client; readonly id: string }) {
  const { loaded, reload } = useRequest(id, (signal) => client.get("/attempts/{id}", { id, signal }));
  const attempt = loaded.state === "ready" ? loaded.value : undefined;
  const recording = attempt?.state === "recording" || attempt?.state === "ticketed";
  useRefresh(recording, kPollMs, reload);
  return (
    <>
      <nav class="trail" aria-label={say("common.where")}>
        <a href="/live">{say("nav.live")}</a>
      </nav>
      <PageTitle document={say("nav.live")}>{attempt === undefined ? say("nav.live") : attempt.station.name}</PageTitle>
      <Waits loaded={loaded} reload={reload} what={say("loading.attempt")} failed={say("attempt.failed")} />
      {attempt !== undefined && (
        <>
          <p class="byline">
            {attempt.person.display_name} · {exerciseTitle(attempt.exercise)}
          </p>
          {recording ? (
            <Watched client={client} attempt={attempt} onEnd={reload} />
          ) : (
            <Notice tone="neutral" title={say("live.is_finished")}>
              <p>
                <a href={`/attempts/${id}`}>{say("live.see")}</a>
              </p>
            </Notice>
          )}
        </>
      )}
    </>
  );
}

function Watched({
  client,
  attempt,
  onEnd,
}: {
  readonly client: Client;
  readonly attempt: AttemptDetail;
  readonly onEnd: () => void;
}) {
  const rateHz = rateOf(attempt);
  const { loaded } = useRequest(attempt.exercise.id, (signal) =>
    client.tagged("GET", "/exercises/{id}", { id: attempt.exercise.id, signal }),
  );
  const exercise = loaded.state === "ready" ? loaded.value.value : undefined;
  const plans = usePlans(client, exercise === undefined ? [] : [exercise]).get(attempt.exercise.id);
  const track = useTracks([{ id: attempt.id, rateHz }], onEnd).get(attempt.id) ?? emptyTrack;
  const cut = useCuts(client, [attempt.id]).get(attempt.id);
  const last = track.rows.at(-1);
  return (
    <>
      <div class="title-row">
        <LiveState track={track} />
        <ForceNow track={track} />
        <p class="hint">{cutText(workpieceOf(exercise, plans?.above, attempt, cut))}</p>
      </div>
      {track.state === "disturbed" && (
        <Notice tone="warning">
          <p>{track.problem}</p>
        </Notice>
      )}
      {last === undefined ? (
        <Empty>{say("live.waiting_station")}</Empty>
      ) : (
        <>
          <dl class="facts">
            <div>
              <dt>{say("live.time_in")}</dt>
              <dd>{formatDuration(last.tick / rateHz)}</dd>
            </div>
            <div>
              <dt>{say("live.largest", { seconds: String(kTrackSeconds) })}</dt>
              <dd>{formatNumber(largestForce(track.rows))} N</dd>
            </div>
            <div>
              <dt>{say("common.device")}</dt>
              <dd>{wordedTitle(attempt.profile.title)}</dd>
            </div>
          </dl>
          <div class="columns">
            {[kFromAbove, kFromSide].map((plane) => (
              <Card key={plane.name} title={say(`live.from_${plane.name}`)}>
                <ToolView
                  rows={track.rows}
                  rateHz={rateHz}
                  plane={plane}
                  workpiece={workpieceOf(exercise, plans?.[plane.name], attempt, cut)}
                />
              </Card>
            ))}
          </div>
          <Card title={say("live.force_last", { seconds: String(kTrackSeconds) })}>
            <ForceStrip rows={track.rows} rateHz={rateHz} />
          </Card>
        </>
      )}
      <ChairRemarks client={client} attempt={attempt.id} rateHz={rateHz} />
    </>
  );
}

function rateOf({ ticks, gap_ticks: gaps, duration_s: seconds }: AttemptDetail): number {
  return seconds > 0 ? (ticks + gaps) / seconds : kDefaultRateHz;
}
