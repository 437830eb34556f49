import type { ComponentChildren } from "preact";
import { useMemo } from "preact/hooks";
import type { Client } from "../../api/client";
import { type Anatomy, anatomyOf, toScene } from "../../api/tooth_number";
import type { Exercise } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { say } from "../../base/words";
import { Card, Waits } from "../../widgets/basics";
import { angledFrom } from "../../widgets/tooth/angled";
import { TissueLegend } from "../../widgets/tooth/legend";
import type { AngledView, Extent, PointMm, ToothLines } from "../../tooth/messages";
import { useStillFilm } from "../../widgets/tooth/still_film";
import { tissueTitle, workpiece } from "../../widgets/tooth/tissue";
import { ToothView } from "../../widgets/tooth/tooth_view";

const kFromTop = 0.35; // of the tooth's height: the work is at the crown, not in the middle of the roots

interface Props {
  readonly client: Client;
  readonly exercise: Exercise;
  readonly title: string;
  readonly lines?: ToothLines | undefined; // over the tooth
  readonly children?: ComponentChildren; // below it
}

// What one will find at the station: the tooth or block before anything is cut.
export function InitialTooth({ client, exercise, title, lines, children }: Props) {
  const { loaded, reload } = useRequest(exercise.scene_sha256 + exercise.id, (signal) =>
    client.bytes("/exercises/{id}/initial-surface", { id: exercise.id, signal }),
  );
  return (
    <Card title={title} className="tooth-card">
      <Waits
        loaded={loaded}
        reload={reload}
        what={say("loading.picture")}
        failed={say("exercise_page.picture_failed")}
      />
      {loaded.state === "ready" && <Tooth surface={loaded.value} target={exercise.target} lines={lines} />}
      {children}
    </Card>
  );
}

function Tooth({
  surface,
  target,
  lines,
}: {
  readonly surface: ArrayBuffer;
  readonly target: Exercise["target"];
  readonly lines: ToothLines | undefined;
}) {
  const still = useStillFilm(surface);
  const anatomy = useMemo((): Anatomy => anatomyOf(target), [target]);
  const extent = still.state === "ready" ? still.value.extent : undefined;
  const angled = useMemo(
    (): AngledView => ({
      direction: angledFrom(anatomy.mesial),
      centre: extent === undefined ? undefined : crownOf(extent, anatomy),
    }),
    [extent, anatomy],
  );
  if (still.state !== "ready")
    return <Waits loaded={still} what={say("loading.picture")} failed={say("exercise_page.picture_failed")} />;
  const { film, tissues } = still.value;
  return (
    <>
      <ToothView
        film={film}
        anatomy={anatomy}
        mode="tissue"
        angled={angled}
        lines={lines}
        label={say(`exercise_page.shows_${workpiece(tissues)}`, { tissues: tissues.map(tissueTitle).join(", ") })}
      />
      <TissueLegend tissues={tissues} />
    </>
  );
}

function crownOf({ centreMm, radiusMm }: Extent, anatomy: Anatomy): PointMm {
  const occlusal = toScene(anatomy, [0, 0, 1]);
  const along = (axis: 0 | 1 | 2) => centreMm[axis] + (1 - 2 * kFromTop) * radiusMm * occlusal[axis];
  return [along(0), along(1), along(2)];
}
