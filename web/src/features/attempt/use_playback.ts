import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { Series } from "../../api/types";
import { prepareTooth } from "../../widgets/tooth/tooth_view";
import { Playback } from "./playback";
import { stepOfTick, tickOfStep } from "./moments";

const kAskAgainMs = 5000;
const kCursorMs = 250;                          // the plots follow four times a second
const kSpeeds = [0.1, 0.25, 0.5, 1, 2, 4, 8, 16] as const;
const kJumpS = 5;

export interface PlaybackControl {
  readonly playback: Playback;
  readonly speeds: readonly number[];
  readonly playing: boolean;
  readonly speed: number;
  // Frames a second at speed 1.
  readonly rate: number;
  readonly toggle: () => void;
  readonly setSpeed: (speed: number) => void;
  readonly show: (frames: number) => void;
  readonly step: (frames: number) => void;
  readonly jump: (direction: -1 | 1) => void;
}

// Plays an attempt back, with the cursor of the page's plots. Undefined: there is no recording, or the page may not see it.
export function usePlayback(client: Client, attempt: string | undefined, series: Series | undefined, cursor: number | undefined,
                            setCursor: (step: number) => void): PlaybackControl | undefined {
  const [, redraw] = useState(0);
  const [round, setRound] = useState(0);
  const playback = useMemo(() => attempt === undefined ? undefined : new Playback(client, attempt, () => redraw((n) => n + 1)), [client, attempt, round]);
  const [playing, setPlaying] = useState(false);
  const [speed, setSpeed] = useState(1);
  // Which run of the playback it is: a frame that was asked for before somebody chose another moment must not undo that.
  const run = useRef(0);
  const stop = () => {
    ++run.current;
    setPlaying(false);
  };
  const ownStep = useRef<number | undefined>(undefined);             // that this set the cursor to

  useEffect(() => {
    setPlaying(false);
    if (playback === undefined) return undefined;
    prepareTooth();
    void playback.load();
    return () => playback.dispose();
  }, [playback]);

  const waits = playback?.state.state === "waiting";
  useEffect(() => {
    if (!waits) return undefined;
    const timer = setTimeout(() => setRound((n) => n + 1), kAskAgainMs);
    return () => clearTimeout(timer);
  }, [waits, round]);

  const head = playback?.head;
  const ready = playback?.state.state === "ready";
  const rate = head === undefined ? 10 : head.rateHz / head.frameTicks;

  // Who moves the cursor elsewhere moves the tooth.
  useEffect(() => {
    if (playback === undefined || head === undefined || !ready || series === undefined || cursor === undefined || cursor === ownStep.current) return;
    ownStep.current = cursor;
    stop();
    playback.show(framesAt(series, cursor, head.frameTicks, playback.frames));
  }, [playback, ready, series, cursor]);

  const tell = (frames: number) => {
    if (series === undefined || head === undefined) return;
    const step = stepOfTick(series, frames * head.frameTicks);
    if (step === ownStep.current) return;
    ownStep.current = step;
    setCursor(step);
  };
  const latestTell = useRef(tell);
  latestTell.current = tell;

  useEffect(() => {
    if (!playing || playback === undefined) return undefined;
    let at = playback.position >= playback.frames ? 0 : playback.position;
    let before: number | undefined;
    let told = 0;
    const own = ++run.current;
    let handle = requestAnimationFrame(function next(now) {
      if (own !== run.current) return;
      at = Math.min(at + (now - (before ?? now)) / 1000 * rate * speed, playback.frames);
      before = now;
      if (Math.floor(at) !== playback.position) playback.show(Math.floor(at));
      const ended = at >= playback.frames;
      if (ended || now - told > kCursorMs) {
        told = now;
        latestTell.current(Math.floor(at));
      }
      if (ended) setPlaying(false);
      else handle = requestAnimationFrame(next);
    });
    return () => cancelAnimationFrame(handle);
  }, [playing, playback, speed, rate]);

  if (playback === undefined) return undefined;
  const show = (frames: number) => {
    const wanted = Math.max(0, Math.min(Math.round(frames), playback.frames));
    stop();
    playback.show(wanted);
    tell(wanted);
  };
  return {
    playback, playing, speed, rate, setSpeed, show, speeds: kSpeeds,
    toggle: () => setPlaying((was) => !was && ready),
    step: (frames) => show(playback.position + frames),
    jump: (direction) => show(playback.position + direction * kJumpS * rate),
  };
}

// The frame at the end of a step, whose tooth and bur the step's figures are of.
function framesAt(series: Series, step: number, frameTicks: number, frames: number): number {
  return step >= series.t_s.length - 1 ? frames : Math.min(frames, Math.round(tickOfStep(series, step + 1) / frameTicks));
}
