import type { Client } from "../../api/client";
import { forceSize } from "../../api/live";
import type { Attempt } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { useRefresh } from "../../api/use_refresh";
import { relativeTime } from "../../base/local_time";
import { Badge, Empty, ErrorNotice, Loading, PageTitle } from "../../widgets/basics";
import { AnchorView, ForceStrip, kFromAbove } from "./live_pictures";
import { emptyTrack, flagTexts, kDefaultRateHz, type Track } from "./track";
import { useTracks } from "./use_tracks";

const kPollMs = 5000;
const kMostShown = 100;

// What is being made at the stations now, of the cohorts the caller may see.
export function LivePage({ client }: { readonly client: Client }) {
  const { loaded, reload } = useRequest("live", (signal) => client.attempts({ state: "recording", limit: kMostShown }, signal));
  useRefresh(true, kPollMs, reload);
  const attempts = loaded.state === "ready" ? loaded.value.items : [];
  const tracks = useTracks(attempts.map((attempt) => ({ id: attempt.id, rateHz: kDefaultRateHz })), reload);
  return (
    <>
      <PageTitle document="Live">Live</PageTitle>
      {loaded.state === "loading" && <Loading what="the stations in use" />}
      {loaded.state === "failed" && <ErrorNotice title="The stations in use could not be loaded" message={loaded.error.message} onRetry={reload} />}
      {loaded.state === "ready" && (attempts.length === 0
        ? <Empty>Nobody is working at a station now. Attempts appear here by themselves as soon as they begin.</Empty>
        : (
          <ul class="card-list live-list">
            {attempts.map((attempt) => <li key={attempt.id}><LiveCard attempt={attempt} track={tracks.get(attempt.id) ?? emptyTrack} /></li>)}
          </ul>
        ))}
      {attempts.length > 3 && <p class="hint">Three stations are followed at a time, each in turn. Open one to follow it without a break.</p>}
    </>
  );
}

function LiveCard({ attempt, track }: { readonly attempt: Attempt; readonly track: Track }) {
  return (
    <article class="card live-card">
      <div class="card-head">
        <h2><a href={`/live/${attempt.id}`}>{attempt.station.name}</a></h2>
        <LiveState track={track} />
      </div>
      <p>{attempt.person.display_name}<span class="hint"> · {attempt.exercise.title}</span></p>
      {track.rows.length === 0 ? <p class="live-waiting hint">{track.state === "disturbed" ? track.problem : "Its picture comes with the first movement."}</p> : (
        <>
          <div class="live-pictures">
            <AnchorView rows={track.rows} rateHz={kDefaultRateHz} plane={kFromAbove} />
            <ForceStrip rows={track.rows} rateHz={kDefaultRateHz} />
          </div>
          <ForceNow track={track} />
        </>
      )}
    </article>
  );
}

export function ForceNow({ track }: { readonly track: Track }) {
  const last = track.rows.at(-1);
  return (
    <p class="live-force">
      <b>{last === undefined ? "–" : `${forceSize(last).toFixed(2)} N`}</b> force now
      {last !== undefined && flagTexts(last.flags).map((text) => <Badge key={text} tone="warning">{text}</Badge>)}
    </p>
  );
}

export function LiveState({ track }: { readonly track: Track }) {
  switch (track.state) {
    case "waiting": return <Badge tone="neutral">Waiting</Badge>;
    case "live": return <Badge tone="good">{Date.now() - track.heardMs < 4000 ? "Live" : `Seen ${relativeTime(track.heardMs, Date.now())}`}</Badge>;
    case "ended": return <Badge tone="neutral">Finished</Badge>;
    case "disturbed": return <Badge tone="warning">No picture</Badge>;
  }
}
