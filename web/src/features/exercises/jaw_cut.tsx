import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { ToothWanted } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { say } from "../../base/words";
import type { PointMm, SurfacePoint, ToothLines } from "../../tooth/messages";
import { Segmented, Waits } from "../../widgets/basics";
import { Button } from "../../widgets/button";
import { useStillFilm } from "../../widgets/tooth/still_film";
import { type ToothPoint, ToothView } from "../../widgets/tooth/tooth_view";

// Points along gums, each list once around a crown: the tooth's, then its neighbours'.
export type GumCurves = readonly (readonly PointMm[])[];

export const kNoCurves: GumCurves = [[], [], []];
export const kLeastPoints = 3;
const kMostPoints = 200;
const kFromFront = { direction: [0.3, -0.6, 0.75] as PointMm, centre: undefined }; // many scanners put the occlusal side up

// What the server is asked for: neighbours that nobody drew are none.
export const drawn = (curves: GumCurves) =>
  curves.filter((points) => points.length > 0).map((points) => [...points]) as ToothWanted["around"]; // at most three

interface Props {
  readonly client: Client;
  readonly id: string; // of the import that showed the scan
  readonly title: string;
  readonly curves: GumCurves;
  readonly onCurves: (curves: GumCurves) => void;
}

// A scan of several teeth, on which a person sets points along the gum of one.
export function JawCut({ client, id, title, curves, onCurves }: Props) {
  const { loaded, reload } = useRequest(id, (signal) => client.bytes("/tooth-imports/{id}/surface", { id, signal }));
  const still = useStillFilm(loaded.state === "ready" ? loaded.value : undefined);
  const [crown, setCrown] = useState("0");
  const heading = useRef<HTMLHeadingElement>(null);
  useEffect(() => heading.current?.focus(), []); // the button that led here is gone
  const chosen = Number(crown);
  const mine = curves[chosen] ?? [];
  const set = (points: readonly PointMm[]) => onCurves(curves.map((curve, i) => (i === chosen ? points : curve)));
  const lines = useMemo(
    (): ToothLines => ({
      solid: curves.filter((points) => points.length > 1).map((points) => [...points, points[0]!]),
      faint: [],
    }),
    [curves],
  );
  const points = useMemo(() => mine.map((pointMm, i): ToothPoint => ({ text: `${i + 1}`, pointMm })), [mine]);
  const full = mine.length >= kMostPoints;
  return (
    <>
      <h3 ref={heading} tabIndex={-1}>
        {title}
      </h3>
      <p>{say("jaw_cut.text")}</p>
      <Segmented
        legend={say("jaw_cut.crown")}
        name="crown"
        value={crown}
        onChange={setCrown}
        choices={[
          { value: "0", title: say("jaw_cut.tooth") },
          { value: "1", title: say("jaw_cut.neighbour", { number: 1 }) },
          { value: "2", title: say("jaw_cut.neighbour", { number: 2 }) },
        ]}
      />
      <Waits
        loaded={loaded.state === "ready" ? still : loaded}
        reload={reload}
        what={say("loading.picture")}
        failed={say("exercise_page.picture_failed")}
      />
      {still.state === "ready" && (
        <div class="stance">
          <ToothView
            film={still.value.film}
            anatomy={undefined}
            mode="tissue"
            angled={kFromFront}
            lines={lines}
            points={points}
            led={true}
            label={say("jaw_cut.shows")}
            onPick={full ? undefined : ({ pointMm }: SurfacePoint) => set([...mine, pointMm])}
          />
        </div>
      )}
      <p aria-live="polite">{say("jaw_cut.count", { count: mine.length })}</p>
      <div class="button-row">
        <Button
          kind="small"
          tip={say("jaw_cut.undo")}
          blocked={mine.length === 0 ? say("jaw_cut.none") : undefined}
          onClick={() => set(mine.slice(0, -1))}
        >
          {say("jaw_cut.undo")}
        </Button>
        <Button
          kind="small"
          tip={say("jaw_cut.clear")}
          blocked={mine.length === 0 ? say("jaw_cut.none") : undefined}
          onClick={() => set([])}
        >
          {say("jaw_cut.clear")}
        </Button>
      </div>
    </>
  );
}
