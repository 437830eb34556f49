import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import type { Client } from "../../api/client";
import { type Anatomy, type MesialX, toScene } from "../../api/tooth_number";
import type { ToothStance } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { formatNumber } from "../../base/format";
import { say } from "../../base/words";
import type { Extent, PointMm, SectionPlane, ToothLines } from "../../tooth/messages";
import { Waits } from "../../widgets/basics";
import { Button } from "../../widgets/button";
import { TissueLegend } from "../../widgets/tooth/legend";
import { SectionTools } from "../../widgets/tooth/section_tools";
import { useStillFilm } from "../../widgets/tooth/still_film";
import { tissueTitle } from "../../widgets/tooth/tissue";
import { ToothView } from "../../widgets/tooth/tooth_view";
import { axesIn, type MouthAxis, turnedAbout, type Upright } from "./upright";

const kAxes: readonly MouthAxis[] = ["occlusal", "buccal", "mesial"];
const kTurnsDeg = [-90, -5, 5, 90] as const;
const kFromHere: PointMm = [0.9, 0.8, 0.6]; // mesial, buccal, occlusal: no arrow points at the viewer
// Shares of the radius of the ball around the tooth: the arrows stand out of it, with room for their names.
const [kArrow, kHead, kThick] = [1, 0.1, 0.005];
const kCloser = 1.15;
const kOpen: SectionPlane = { across: "view", share: 0, flipped: false };

// A tooth that the server made and did not publish.
export interface Shown {
  readonly id: string; // of its import
  readonly stance: ToothStance;
  readonly found: Upright; // the same
  readonly findings: readonly string[];
}

interface Props {
  readonly client: Client;
  readonly shown: Shown;
  readonly title: string;
  readonly busy: boolean; // what is being done is done as it is turned now
  readonly mesial: MesialX;
  readonly upright: Upright; // as it is turned now
  readonly onTurn: (upright: Upright) => void;
  readonly onAgain: () => void; // shows what it is as it is turned now
}

export function uprightOf({ up, buccal }: ToothStance): Upright {
  return { up: pointOf(up), buccal: pointOf(buccal) };
}
function pointOf([x = 0, y = 0, z = 0]: readonly number[]): PointMm {
  return [x, y, z];
}

// A tooth that is not published yet, to turn and to cut open.
export function ToothUpright(props: Props) {
  const { client, shown, title, busy, mesial, upright, onTurn, onAgain } = props;
  const { id, stance, found } = shown;
  const { loaded, reload } = useRequest(id, (signal) => client.bytes("/tooth-imports/{id}/surface", { id, signal }));
  const [x, y, z] = pointOf(stance.size_mm);
  const size = (mm: number) => formatNumber(mm, 1);
  const heading = useRef<HTMLHeadingElement>(null);
  useEffect(() => heading.current?.focus(), []); // the button that led here is gone
  return (
    <>
      <h3 ref={heading} tabIndex={-1}>
        {title}
      </h3>
      <Waits
        loaded={loaded}
        reload={reload}
        what={say("loading.picture")}
        failed={say("exercise_page.picture_failed")}
      />
      {loaded.state === "ready" && <Picture key={id} {...props} surface={loaded.value} />}
      {!busy && (
        <div class="form-grid">
          {kAxes.map((axis) => (
            <div key={axis} role="group" aria-label={turnTitle(axis)}>
              <p class="hint">{turnTitle(axis)}</p>
              <div class="button-row">
                {kTurnsDeg.map((degrees) => (
                  <button
                    key={degrees}
                    type="button"
                    class="button small"
                    onClick={() => onTurn(turnedAbout(upright, mesial, axis, degrees))}
                  >
                    {say("tooth_import.degrees", { degrees: `${degrees < 0 ? "−" : "+"}${Math.abs(degrees)}` })}
                  </button>
                ))}
              </div>
            </div>
          ))}
        </div>
      )}
      {upright !== found && !busy && (
        <div class="button-row">
          <button type="button" class="button small" onClick={() => onTurn(found)}>
            {say("tooth_import.undo")}
          </button>
          <button type="button" class="button small" onClick={onAgain}>
            {say("tooth_import.again")}
          </button>
        </div>
      )}
      {upright === found && (
        <p>
          {stanceText(stance)} {say("tooth_import.size", { x: size(x), y: size(y), z: size(z) })}
        </p>
      )}
    </>
  );
}

const turnTitle = (axis: MouthAxis) => say("tooth_import.turn", { axis: say(`view.${axis}`) });

function stanceText({ up_is, by, buccal_given }: ToothStance): string {
  const kinds = by.map((kind) => say(`tooth_import.by_${kind}`)).join(", ");
  const up =
    up_is === "given"
      ? say("tooth_import.up_given")
      : up_is === "found"
        ? say("tooth_import.up_found", { kinds })
        : kinds === ""
          ? say("tooth_import.up_guess")
          : say("tooth_import.up_guess_by", { kinds });
  return buccal_given ? up : `${up} ${say("tooth_import.buccal_guess")}`;
}

function Picture({ client, shown, surface, mesial, upright }: Props & { readonly surface: ArrayBuffer }) {
  const { id, found } = shown;
  const still = useStillFilm(surface);
  const [section, setSection] = useState<SectionPlane>();
  const [inside, setInside] = useState<readonly number[]>();
  const [problem, setProblem] = useState<string>();
  const anatomy = useMemo(
    (): Anatomy => ({ mesial, up: "occlusal", turn: axesIn(found, upright) }),
    [mesial, found, upright],
  );
  const angled = useMemo(
    () => ({ direction: toScene(anatomy, kFromHere), centre: undefined, closer: kCloser }),
    [anatomy],
  );
  const extent = still.state === "ready" ? still.value.extent : undefined;
  const arrows = useMemo(() => (extent === undefined ? [] : arrowsOf(extent, anatomy)), [extent, anatomy]);
  const lines = useMemo((): ToothLines => ({ solid: arrows.flatMap(({ lines }) => lines), faint: [] }), [arrows]);
  if (still.state !== "ready")
    return <Waits loaded={still} what={say("loading.picture")} failed={say("exercise_page.picture_failed")} />;
  const { film, tissues } = still.value;
  // Tissues were laid by the way it stood.
  const turned = upright !== found;
  const cut = async () => {
    setSection(section === undefined ? kOpen : undefined);
    if (inside !== undefined) return;
    const bytes = await client.bytes("/tooth-imports/{id}/start-tooth", { id });
    const told = bytes.ok ? await film.interior(bytes.value) : bytes;
    if (told.ok) setInside(told.value);
    else setProblem(typeof told.error === "string" ? told.error : told.error.message);
  };
  return (
    <div class="stance">
      <ToothView
        film={film}
        anatomy={anatomy}
        mode="tissue"
        angled={angled}
        lines={lines}
        points={arrows}
        section={turned ? undefined : section}
        label={say("tooth_import.shows", { tissues: tissues.map(tissueTitle).join(", ") })}
      >
        <div class="tooth-choices">
          <Button
            kind="small"
            aria-pressed={section !== undefined && !turned}
            blocked={turned ? say("tooth_import.again_first") : undefined}
            tip={say("section.title")}
            onClick={() => void cut()}
          >
            {say("section.title")}
          </Button>
          {section !== undefined && !turned && <SectionTools section={section} onSection={setSection} />}
        </div>
      </ToothView>
      <TissueLegend tissues={section !== undefined && !turned ? (inside ?? tissues) : tissues} />
      {problem !== undefined && <p class="hint">{say("section.not_opened", { reason: problem })}</p>}
    </div>
  );
}

// From the tooth's middle through its side. A line is a pixel wide, so each is drawn five times.
function arrowsOf({ centreMm, radiusMm }: Extent, anatomy: Anatomy) {
  const at = (m: number, b: number, o: number): PointMm => {
    const [x, y, z] = toScene(anatomy, [m * radiusMm, b * radiusMm, o * radiusMm]);
    return [centreMm[0] + x, centreMm[1] + y, centreMm[2] + z];
  };
  return (["mesial", "buccal", "occlusal"] as const).map((axis, i) => {
    // Along the arrow, and square to it.
    const point = (along: number, aside: number, across: number) => {
      const of = [along, aside, across];
      return at(of[(3 - i) % 3]!, of[(4 - i) % 3]!, of[(5 - i) % 3]!);
    };
    const arrow = (aside: number, across: number) => [
      [point(0, aside, across), point(kArrow, aside, across)],
      [point(kArrow - kHead, aside + kHead / 2, across), point(kArrow, aside, across)],
      [point(kArrow - kHead, aside - kHead / 2, across), point(kArrow, aside, across)],
    ];
    return {
      text: say(`view.${axis}`),
      pointMm: point(kArrow + kHead, 0, 0),
      lines: [...arrow(0, 0), ...[-kThick, kThick].flatMap((off) => [...arrow(off, 0), ...arrow(0, off)])],
    };
  });
}
