import { exerciseTitle } from "../../api/builtin_words";
import { criterionTitle } from "../../api/worded";
import type { AgreementFigure, Marking, MarkingResults } from "../../api/types";
import { csvText } from "../../base/csv";
import { downloadFile, fileName } from "../../base/download";
import { formatPoints, formatScore } from "../../base/format";
import { say } from "../../base/words";
import { Card, Notice } from "../../widgets/basics";
import { DataTable } from "../../widgets/table";
import { type CriterionAgreement, formatCoefficient, markedAlone, marksTable, ratedPoints } from "./results";
import { StandardPlot } from "./standard_plot";

interface Props {
  readonly marking: Marking;
  readonly results: MarkingResults;
}

// Whose work it was, what each marker and the program gave, how well they agree, and the pass mark that follows.
export function MarkingResultsView({ marking, results }: Props) {
  const save = () => {
    const { header, rows } = marksTable(marking, results);
    downloadFile(`${fileName(exerciseTitle(marking.exercise), "marks")}.csv`, "text/csv", csvText(header, rows));
  };
  return (
    <>
      <PassMark results={results} />
      <Card
        title={say("marking.results")}
        aside={
          <button type="button" class="button small" onClick={save}>
            {say("common.save_csv")}
          </button>
        }
      >
        <DataTable
          label={say("marking.results")}
          items={results.works}
          rowKey={({ id }) => id}
          columns={[
            {
              title: say("marking.student"),
              cell: ({ attempt_id: attempt, person }) => <a href={`/attempts/${attempt}`}>{person.display_name}</a>,
            },
            ...marking.markers.map((marker) => ({
              title: marker.display_name,
              cell: ({ marks }: MarkingResults["works"][number]) => {
                const mark = marks.find(({ marker_id: id }) => id === marker.id);
                return mark === undefined
                  ? "–"
                  : say("marking.total_and_rating", {
                      total: formatScore(mark.total),
                      rating: say(`marking.rating_${mark.rating as 1 | 2 | 3 | 4 | 5}`),
                    });
              },
            })),
            {
              title: say("marking.computed"),
              number: true,
              cell: ({ computed_score: score }) => formatScore(score),
            },
          ]}
        />
      </Card>
      <Agreement results={results} />
    </>
  );
}

// "0.82 (0.64 to 0.92)".
function figureText(figure: AgreementFigure | undefined): string {
  const { value, low, high }: AgreementFigure = figure ?? { value: null };
  if (value === null) return "–";
  const form = formatCoefficient;
  return low === undefined || high === undefined
    ? form(value)
    : say("marking.interval", { value: form(value), low: form(low), high: form(high) });
}

function noPassMark({ needs }: MarkingResults["standard"]["borderline"], works: MarkingResults["works"]): string {
  if (works.length < needs.works)
    return say("marking.too_few", {
      count: works.length,
      least: String(needs.works),
      enough: String(needs.enough),
    });
  const ratings = new Set(works.flatMap(({ marks }) => marks.map(({ rating }) => rating)));
  return ratings.size < needs.ratings
    ? say("marking.too_alike", { least: String(needs.ratings) })
    : say("marking.no_pass_mark");
}

function PassMark({ results: { standard, works } }: { readonly results: MarkingResults }) {
  const { borderline, phi_at_cut: phi } = standard;
  const points = ratedPoints(works);
  return (
    <Card title={say("marking.pass_mark")} className="pass-mark">
      {borderline.value === null ? (
        <p>{noPassMark(borderline, works)}</p>
      ) : (
        <>
          <p class="pass-mark-value">
            {say("marking.pass_mark_at", {
              points: formatPoints(borderline.value),
              low: formatPoints(borderline.low ?? borderline.value),
              high: formatPoints(borderline.high ?? borderline.value),
            })}
          </p>
          <p>{say("marking.borderline_text", { count: borderline.works ?? points.length })}</p>
          {phi.value !== null && <p>{say("marking.phi_text", { phi: formatCoefficient(phi.value) })}</p>}
          <StandardPlot points={points} cut={borderline.value} slope={borderline.points_per_rating ?? 0} />
        </>
      )}
      {borderline.few === true && (
        <Notice tone="warning">
          <p>
            {say("marking.few", {
              count: borderline.works ?? points.length,
              enough: String(borderline.needs.enough),
            })}
          </p>
        </Notice>
      )}
      <p class="hint">{say("marking.school_decides")}</p>
    </Card>
  );
}

function Agreement({ results: { agreement } }: { readonly results: MarkingResults }) {
  const named = (criterion: string) =>
    criterion === "total"
      ? say("marking.all_points")
      : criterion === "rating"
        ? say("marking.rating")
        : criterionTitle({ name: criterion.toLowerCase().replaceAll(" ", "_"), title: criterion });
  // The whole first.
  const whole = (criterion: string) => (criterion === "total" ? 0 : criterion === "rating" ? 1 : 2);
  const alone = markedAlone(agreement);
  const rows = (alone ? agreement.filter(({ computed }) => computed !== undefined) : [...agreement]).sort(
    (a, b) => whole(a.criterion) - whole(b.criterion),
  );
  return (
    <Card title={say("marking.agreement")}>
      {alone && <p>{say("marking.second_marker")}</p>}
      {rows.length > 0 && (
        <>
          <p class="hint">{say("marking.agreement_hint")}</p>
          <DataTable
            label={say("marking.agreement")}
            items={rows}
            rowKey={({ criterion }) => criterion}
            columns={[
              { title: say("marking.criterion"), cell: ({ criterion }) => named(criterion) },
              ...(alone
                ? []
                : [
                    {
                      title: say("marking.one_marker"),
                      cell: ({ icc_2_1: icc }: CriterionAgreement) => figureText(icc),
                    },
                    { title: say("marking.mean_of_all"), cell: ({ phi }: CriterionAgreement) => figureText(phi) },
                  ]),
              {
                title: say("marking.with_program"),
                cell: ({ computed }) => figureText(computed?.icc_2_1_with_mean),
              },
            ]}
          />
          {rows.some(lacksFigure) && <p class="hint">{say("marking.no_figure")}</p>}
        </>
      )}
    </Card>
  );
}

function lacksFigure({ icc_2_1: icc, phi, computed }: CriterionAgreement): boolean {
  return [icc, phi, computed?.icc_2_1_with_mean].some((figure) => figure?.value === null);
}
