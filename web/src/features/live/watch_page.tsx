import type { Client } from "../../api/client";
import type { AttemptDetail } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { useRefresh } from "../../api/use_refresh";
import { formatDuration, formatNumber } from "../../base/format";
import { Card, Empty, ErrorNotice, Loading, Notice, PageTitle } from "../../widgets/basics";
import { ForceNow, LiveState } from "./live_page";
import { AnchorView, ForceStrip, kFromAbove, kFromBuccal } from "./live_pictures";
import { emptyTrack, kDefaultRateHz, kTrackSeconds, largestForce } from "./track";
import { useTracks } from "./use_tracks";

const kPollMs = 5000;

// One attempt as it is being made.
export function WatchPage({ client, id }: { readonly client: Client; readonly id: string }) {
  const { loaded, reload } = useRequest(id, (signal) => client.attempt(id, signal));
  const attempt = loaded.state === "ready" ? loaded.value : undefined;
  const recording = attempt?.state === "recording" || attempt?.state === "ticketed";
  useRefresh(recording, kPollMs, reload);
  return (
    <>
      <nav class="trail" aria-label="Where you are"><a href="/live">Live</a></nav>
      <PageTitle document="Live">{attempt === undefined ? "Live" : attempt.station.name}</PageTitle>
      {loaded.state === "loading" && <Loading what="the attempt" />}
      {loaded.state === "failed" && <ErrorNotice title="The attempt could not be loaded" message={loaded.error.message} onRetry={reload} />}
      {attempt !== undefined && (
        <>
          <p class="byline">{attempt.person.display_name} · {attempt.exercise.title}</p>
          {recording ? <Watched attempt={attempt} onEnd={reload} />
            : <Notice tone="neutral" title="This attempt is finished"><p><a href={`/attempts/${id}`}>See the attempt</a></p></Notice>}
        </>
      )}
    </>
  );
}

function Watched({ attempt, onEnd }: { readonly attempt: AttemptDetail; readonly onEnd: () => void }) {
  const rateHz = rateOf(attempt);
  const track = useTracks([{ id: attempt.id, rateHz }], onEnd).get(attempt.id) ?? emptyTrack;
  const last = track.rows.at(-1);
  return (
    <>
      <div class="title-row"><LiveState track={track} /><ForceNow track={track} /></div>
      {track.state === "disturbed" && <Notice tone="warning"><p>{track.problem}</p></Notice>}
      {last === undefined ? <Empty>Waiting for the station. Its picture comes as soon as the first ticks arrive.</Empty> : (
        <>
          <dl class="facts">
            <div><dt>Time in the attempt</dt><dd>{formatDuration(last.tick / rateHz)}</dd></div>
            <div><dt>Largest in {kTrackSeconds} s</dt><dd>{formatNumber(largestForce(track.rows))} N</dd></div>
            <div><dt>Device</dt><dd>{attempt.profile.title}</dd></div>
          </dl>
          <div class="columns">
            {[kFromAbove, kFromBuccal].map((plane) => (
              <Card key={plane.title} title={plane.title}><AnchorView rows={track.rows} rateHz={rateHz} plane={plane} /></Card>
            ))}
          </div>
          <Card title={`Force, last ${kTrackSeconds} seconds`}><ForceStrip rows={track.rows} rateHz={rateHz} /></Card>
        </>
      )}
    </>
  );
}

function rateOf({ ticks, gap_ticks: gaps, duration_s: seconds }: AttemptDetail): number {
  return seconds > 0 ? (ticks + gaps) / seconds : kDefaultRateHz;
}
