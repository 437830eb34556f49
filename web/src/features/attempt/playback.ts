import type { Client } from "../../api/client";
import type { ApiError, ApiResult } from "../../api/http";
import type { FramePose, Head } from "../../api/timeline";
import type { BlockMesh } from "../../api/tooth_mesh";
import type { Compared, Extent } from "../../api/tooth_work";
import { segmentBytes } from "../../api/timeline";
import { startToothWorker, ToothLink } from "../../api/tooth_link";
import { say } from "../../base/words";
import type { Detail, Film, FilmScreen } from "../../widgets/tooth/film";

// An attempt with the tooth being cut. Loads its timeline: first what the tooth at the end needs,
// then the rest. What is loaded goes to a worker, which answers with triangles.

const kFirstBytes = 16_384; // the head of an attempt of six hours

export type PlaybackState =
  | { readonly state: "loading" }
  | { readonly state: "waiting"; readonly message: string } // the server has not made it yet
  | { readonly state: "failed"; readonly error: ApiError }
  | { readonly state: "ready" };

// The tooth at its end against the reference.
export type DeviationState =
  | { readonly state: "loading" }
  | { readonly state: "none" } // nothing to compare with
  | { readonly state: "failed"; readonly error: ApiError }
  | { readonly state: "ready"; readonly compared: Compared };

export class Playback implements Film {
  state: PlaybackState = { state: "loading" };
  deviation: DeviationState = { state: "loading" };
  drawn = false; // the first fine picture was told
  private coarse = false; // a coarse one was
  private tellDrawn = (): void => undefined;
  private readonly firstDrawn = new Promise<void>((resolve) => {
    this.tellDrawn = resolve;
  });
  readonly tissues = new Set<number>(); // that were seen at the surface
  whole = false; // all segments are here
  position = 0; // frames of the tooth that is shown or being made
  head: Head | undefined;
  extent: Extent = { centreMm: [0, 0, 0], radiusMm: 1 };
  cut: Extent | undefined; // where something went, by the end
  private link: ToothLink | undefined;
  wanted = 0; // frames of the tooth that was asked for last
  readonly poses: FramePose[] = []; // by frame, where its segment is here
  private readonly meshes = new Map<number, BlockMesh>();
  private readonly screens = new Set<FilmScreen>();
  private readonly abort = new AbortController();

  // `changed` is called whenever state, position or what is loaded has changed.
  constructor(
    private readonly client: Client,
    private readonly attempt: string,
    private readonly changed: () => void,
  ) {}

  dispose(): void {
    this.abort.abort();
    this.link?.dispose();
    this.screens.clear();
  }

  get detail(): Detail {
    return this.drawn ? "fine" : this.coarse ? "coarse" : "none";
  }
  get frames(): number {
    return this.head?.frames ?? 0;
  }
  // The tooth at `position`, not the one after the attempt.
  get showing(): boolean {
    return this.position < this.frames;
  }

  async load(): Promise<void> {
    const error = await this.loadEnd();
    if (this.abort.signal.aborted) return;
    if (error !== undefined) {
      this.state =
        error.code === "unavailable" ? { state: "waiting", message: error.message } : { state: "failed", error };
      this.changed();
      return;
    }
    this.position = this.wanted = this.frames;
    this.state = { state: "ready" };
    this.link?.seek(this.frames);
    this.changed();
    void this.loadDeviation();
    await this.firstDrawn;
    const rest = await this.loadRest();
    if (this.abort.signal.aborted) return;
    if (rest !== undefined) this.state = { state: "failed", error: rest };
    else this.whole = true;
    this.changed();
  }

  private part(from: number, to: number): Promise<ApiResult<ArrayBuffer>> {
    return this.client.timeline(this.attempt, from, to, this.abort.signal);
  }
  private malformed(message: string): ApiError {
    return { code: "malformed", status: 0, field: "", message: say("playback.malformed", { reason: message }) };
  }
  private fail(message: string): void {
    this.state = { state: "failed", error: this.malformed(message) };
    this.changed();
  }

  // Head, start tooth and last segment: the tooth at the end.
  private async loadEnd(): Promise<ApiError | undefined> {
    let link: ToothLink;
    try {
      link = this.link = new ToothLink(startToothWorker(), {
        blocks: (blocks) => this.setBlocks(blocks),
        shown: (frames, cut) => this.shown(frames, cut),
        failed: (message) => this.fail(message),
      });
    } catch {
      return { code: "unreachable", status: 0, field: "", message: say("playback.no_worker") };
    }
    const coarse = this.loadCoarse(link);
    const first = await this.part(0, kFirstBytes);
    if (!first.ok) return first.error;
    const head = await link.head(first.value);
    if (!head.ok) return this.malformed(head.error);
    this.head = head.value;
    const last = head.value.segments.length - 1;
    const [start, segment] = await Promise.all([
      coarse.then(() => this.loadStart(link, head.value)),
      last < 0 ? undefined : this.loadLast(link, head.value, last),
    ]);
    return start ?? segment;
  }
  // Something to look at, before hundreds of kB more. Without it nothing is lost.
  private async loadCoarse(link: ToothLink): Promise<void> {
    const bytes = await this.client.coarseTooth(this.attempt, this.abort.signal);
    const extent = bytes.ok ? await link.coarse(bytes.value) : undefined;
    if (extent?.ok !== true || this.drawn) return;
    this.extent = extent.value;
    this.coarse = true;
    this.changed();
  }
  private async loadStart(link: ToothLink, head: Head): Promise<ApiError | undefined> {
    const bytes = await this.client.startTooth(head.start, this.abort.signal);
    if (!bytes.ok) return bytes.error;
    const extent = await link.start(bytes.value);
    if (!extent.ok) return this.malformed(extent.error);
    if (!this.coarse) this.extent = extent.value;
    return undefined;
  }
  private async loadLast(link: ToothLink, head: Head, index: number): Promise<ApiError | undefined> {
    const segment = head.segments[index]!;
    const bytes = await this.part(segment.from, segment.from + segmentBytes(segment));
    return bytes.ok ? this.takeSegment(link, head, index, bytes.value) : bytes.error;
  }
  private async takeSegment(
    link: ToothLink,
    head: Head,
    index: number,
    bytes: ArrayBuffer,
  ): Promise<ApiError | undefined> {
    const poses = await link.segment(index, bytes);
    if (!poses.ok) return this.malformed(poses.error);
    poses.value.forEach((pose, i) => {
      this.poses[index * head.segmentFrames + i] = pose;
    });
    return undefined;
  }

  private async loadDeviation(): Promise<void> {
    const bytes = await this.client.deviation(this.attempt, this.abort.signal);
    const compared = bytes.ok ? await this.link?.deviation(bytes.value) : undefined;
    if (this.abort.signal.aborted) return;
    if (!bytes.ok)
      this.deviation = bytes.error.code === "not_found" ? { state: "none" } : { state: "failed", error: bytes.error };
    else if (compared?.ok === true) this.deviation = { state: "ready", compared: compared.value };
    else this.deviation = { state: "failed", error: this.malformed(compared?.error ?? say("playback.closed")) };
    this.changed();
  }

  // All other segments, in one answer: together they are smaller than a photograph.
  private async loadRest(): Promise<ApiError | undefined> {
    const { head, link } = this;
    const last = head?.segments.at(-1);
    if (head === undefined || link === undefined || last === undefined || last.from === head.bytes) return undefined;
    const bytes = await this.part(head.bytes, last.from);
    if (!bytes.ok) return bytes.error;
    for (const [i, segment] of head.segments.slice(0, -1).entries()) {
      const at = segment.from - head.bytes;
      const error = await this.takeSegment(link, head, i, bytes.value.slice(at, at + segmentBytes(segment)));
      if (error !== undefined) return error;
    }
    return undefined;
  }

  attach(screen: FilmScreen): () => void {
    this.screens.add(screen);
    for (const [block, mesh] of this.meshes) screen.setBlock(block, mesh);
    this.tell(screen);
    return () => {
      this.screens.delete(screen);
    };
  }
  private tell(screen: FilmScreen): void {
    screen.setBur(this.head?.outline ?? [], this.showing ? this.pose(this.position) : undefined);
  }
  private setBlocks(blocks: readonly (readonly [number, BlockMesh | undefined])[]): void {
    for (const [block, mesh] of blocks) {
      if (mesh === undefined) this.meshes.delete(block);
      else this.meshes.set(block, mesh);
      for (const tissue of mesh?.tissue ?? []) this.tissues.add(tissue);
      for (const screen of this.screens) screen.setBlock(block, mesh);
    }
  }
  private shown(frames: number, cut: Extent | undefined): void {
    this.cut ??= cut;
    if (frames === this.position && this.drawn) return;
    this.drawn = true;
    this.tellDrawn();
    this.position = frames;
    for (const screen of this.screens) this.tell(screen);
    this.changed();
  }

  // After so many frames; before the first one as after it.
  pose(frames: number): FramePose | undefined {
    return this.poses[Math.max(frames, 1) - 1];
  }

  // Shows the tooth after so many frames; the latest wish counts.
  show(frames: number): void {
    const wanted = Math.max(0, Math.min(Math.round(frames), this.frames));
    if (wanted === this.wanted) return;
    this.wanted = wanted;
    this.tellDrawn(); // it may need the rest
    for (const screen of this.screens) screen.expect();
    this.link?.seek(wanted);
  }
}
