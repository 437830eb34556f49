import { formatMoment, formatNumber } from "../../base/format";
import { say } from "../../base/words";
import type { Gap } from "./clock";
import type { PlaybackControl } from "./use_playback";

// Play, pause, speed, what is played again, and the moment of the tooth's picture.
export function PlaybackBar({ control }: { readonly control: PlaybackControl }) {
  const { playback, clock, playing, speed, speeds, loop } = control;
  const { state } = playback;
  if (state.state === "waiting")
    return (
      <p class="hint" role="status">
        {say("playback.waiting")}
      </p>
    );
  if (state.state === "failed")
    return (
      <p class="hint" role="status">
        {say("playback.cannot", { reason: state.error.message })}
      </p>
    );
  if (state.state === "loading" || !playback.whole || clock === undefined)
    return (
      <p class="hint" role="status">
        {say("loading.playback")}
      </p>
    );
  if (playback.frames === 0) return null;
  const { gaps } = clock;
  const time = (frames: number) => formatMoment(clock.timeOf(frames));
  const share = (frames: number) => `${(100 * frames) / playback.frames}%`;
  return (
    <div class="playback no-print" role="group" aria-label={say("playback.title")} data-shown={playback.position}>
      <button
        type="button"
        class="button small"
        aria-label={say("playback.frame_back")}
        title={say("playback.tip_back")}
        onClick={() => control.step(-1)}
      >
        ‹
      </button>
      <button
        type="button"
        class="button small playback-play"
        title={say("playback.tip_play")}
        onClick={control.toggle}
      >
        {playing ? say("playback.pause") : say("playback.play")}
      </button>
      <button
        type="button"
        class="button small"
        aria-label={say("playback.frame_on")}
        title={say("playback.tip_on")}
        onClick={() => control.step(1)}
      >
        ›
      </button>
      <span class="playback-slider">
        <input
          type="range"
          min={0}
          max={playback.frames}
          step={1}
          value={playback.position}
          aria-label={say("playback.position")}
          // A screen reader says the moment once it stays.
          aria-valuetext={
            playing
              ? say("playback.playing")
              : say("count.of", { part: time(playback.position), whole: time(playback.frames) })
          }
          onInput={(event) => control.show(Number(event.currentTarget.value))}
        />
        {gaps.map((gap) => (
          <span key={gap.frames} class="playback-gap" style={{ left: share(gap.frames) }} title={gapText(gap)} />
        ))}
        {loop !== undefined && (
          <span
            class="playback-loop"
            style={{ left: share(loop.from), right: loop.to === undefined ? "0" : `calc(100% - ${share(loop.to)})` }}
          />
        )}
      </span>
      <span class="playback-time">{time(playback.position)}</span>
      <span class="button-row playback-ab">
        <button
          type="button"
          class="button small quiet"
          aria-label={say("playback.from_here")}
          title={say("playback.tip_from")}
          aria-pressed={loop !== undefined}
          onClick={control.loopFrom}
        >
          A
        </button>
        <button
          type="button"
          class="button small quiet"
          aria-label={say("playback.to_here")}
          title={say("playback.tip_to")}
          aria-pressed={loop?.to !== undefined}
          onClick={control.loopTo}
        >
          B
        </button>
        {loop !== undefined && (
          <button
            type="button"
            class="button small quiet"
            aria-label={say("playback.all")}
            title={say("playback.tip_all")}
            onClick={control.loopOff}
          >
            ×
          </button>
        )}
      </span>
      <label class="playback-speed">
        <span class="hidden">{say("playback.speed")}</span>
        <select
          value={speed}
          title={say("playback.tip_speed")}
          onChange={(event) => control.setSpeed(Number(event.currentTarget.value))}
        >
          {speeds.map((value) => (
            <option key={value} value={value}>{`${value}×`}</option>
          ))}
        </select>
      </label>
      {gaps.length > 0 && (
        <span class="hidden">
          {say("playback.not_recorded", {
            list: gaps.map((gap) => say("playback.gap_at", { gap: gapText(gap), moment: time(gap.frames) })).join(", "),
          })}
        </span>
      )}
      {loop !== undefined && (
        <span class="hidden" role="status">
          {loop.to === undefined
            ? say("playback.again_from", { moment: time(loop.from) })
            : say("playback.again_to", { from: time(loop.from), to: time(loop.to) })}
        </span>
      )}
    </div>
  );
}

const gapText = ({ seconds }: Gap) => say("playback.gap", { seconds: formatNumber(seconds, 2) });
