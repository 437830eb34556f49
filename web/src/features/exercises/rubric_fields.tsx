import { useMemo } from "preact/hooks";
import { wordedTitle } from "../../api/builtin_words";
import type { ScoringMetric } from "../../api/types";
import { type Json, type Path, valueAt } from "../../base/document";
import { formatLimit, unitText } from "../../base/format";
import { metricTitle } from "../../base/metric_titles";
import { say } from "../../base/words";
import { Brief } from "../../widgets/basics";
import { Button } from "../../widgets/button";
import { type DocumentForm, DocumentNumber, DocumentText, problemAt } from "../../widgets/document_fields";
import { SelectField } from "../../widgets/form";
import { itemsAt, materialOptions, moreIsBetter } from "./editor_text";
import { PriceFields } from "./price_fields";
import { kLeewayMm } from "./prices_table";

interface Props {
  readonly form: DocumentForm;
  readonly path: Path; // of the rubric; empty: the document is one
  readonly metrics: readonly ScoringMetric[];
}

// What costs points: each part of the cut by its price, and the hand by its criteria.
export function RubricFields({ form, path, metrics }: Props) {
  const list = [...path, "criteria"];
  const criteria = itemsAt(form.edit.at(list));
  const problem = problemAt(form, list);
  const ofHand = useMemo(() => metrics.filter(({ hand }) => hand), [metrics]);
  return (
    <div class="stack">
      <Material form={form} path={path} />
      <section class="stack" aria-label={say("rubric.cut")}>
        <h3>{say("rubric.cut")}</h3>
        <p class="hint">{say("price.once")}</p>
        <p class="hint">{say("price.states_points")}</p>
        <PriceFields form={form} path={path} />
        <p class="hint">{say("price.even_layer", { leeway: formatLimit(kLeewayMm, "mm") })}</p>
        <p class="hint">{say("price.not_done")}</p>
      </section>
      <section class="stack" aria-label={say("rubric.hand")}>
        <h3>{say("rubric.hand")}</h3>
        <p class="hint">{say("rubric.hand_hint")}</p>
        {problem !== undefined && <p class="field-problem">{problem}</p>}
        {criteria.map((item, i) => (
          <Criterion key={i} form={form} list={list} place={i} count={criteria.length} metrics={ofHand} item={item} />
        ))}
        <div>
          <button
            type="button"
            class="button"
            onClick={() => form.edit.set(list, [...criteria, fresh(ofHand, criteria)])}
          >
            {say("rubric.add_criterion")}
          </button>
        </div>
      </section>
    </div>
  );
}

// The restorative material: one of those that the rubric has tolerances for, or none.
function Material({ form, path }: { readonly form: DocumentForm; readonly path: Path }) {
  const place = [...path, "restoration"];
  const options = materialOptions(form.edit.at([...path, "restorations"]), form.edit.at(place));
  if (options.length === 1) return null;
  return (
    <SelectField
      label={say("restoration.material")}
      hint={say("restoration.hint")}
      problem={problemAt(form, place)}
      value={String(form.edit.at(place) ?? "")}
      options={options}
      onValue={(chosen) => form.edit.set(place, chosen === "" ? undefined : chosen)}
    />
  );
}

// Of a metric that the others do not judge yet.
function fresh(metrics: readonly ScoringMetric[], others: readonly Json[]): Json {
  const used = new Set(others.map((item) => valueAt(item, ["metric"])));
  const { name = "", unit = "" } = metrics.find((metric) => !used.has(metric.name)) ?? metrics[0] ?? {};
  return {
    metric: name,
    title: metricTitle(name, unit),
    unit,
    points: 10,
    map: [
      [0, 1],
      [1, 0],
    ],
    comment: "",
  };
}

interface CriterionProps {
  readonly form: DocumentForm;
  readonly list: Path;
  readonly place: number;
  readonly count: number;
  readonly metrics: readonly ScoringMetric[];
  readonly item: Json;
}

function Criterion({ form, list, place, count, metrics, item }: CriterionProps) {
  const path = [...list, place];
  const title = String(valueAt(item, ["title"]) ?? "");
  const metric = String(valueAt(item, ["metric"]) ?? "");
  const unit = String(valueAt(item, ["unit"]) ?? "");
  const name = say("rubric.criterion_name", { number: String(place + 1), title: wordedTitle(title) });
  const choose = (chosen: string) => {
    const known = metrics.find((each) => each.name === chosen);
    // A title that somebody wrote stays; one that is the measurement's own follows it.
    const own = title === "" || title === metricTitle(metric, unit);
    form.edit.set(path, {
      ...(item as { readonly [name: string]: Json }),
      metric: chosen,
      unit: known?.unit ?? unit,
      title: own ? metricTitle(chosen, known?.unit ?? unit) : title,
    });
  };
  const move = (to: number) => {
    const items = [...itemsAt(form.edit.at(list))];
    const [taken] = items.splice(place, 1);
    if (taken !== undefined) items.splice(to, 0, taken);
    form.edit.set(list, items);
  };
  const problem = problemAt(form, path);
  return (
    <fieldset class="group criterion">
      <legend>{name}</legend>
      {problem !== undefined && <p class="field-problem">{problem}</p>}
      <div class="form-grid">
        <SelectField
          label={say("rubric.measured")}
          value={metric}
          problem={problemAt(form, [...path, "metric"])}
          onValue={choose}
          options={(metrics.some((each) => each.name === metric) ? metrics : [{ name: metric, unit }, ...metrics]).map(
            (each) => ({ value: each.name, title: metricTitle(each.name, each.unit) }),
          )}
        />
        <DocumentText form={form} path={[...path, "title"]} label={say("rubric.called")} maxLength={200} />
        <DocumentNumber form={form} path={[...path, "points"]} label={say("rubric.most")} min={0} />
        {(!moreIsBetter(item) || valueAt(item, ["fails_above"]) !== undefined) && (
          <DocumentNumber
            form={form}
            path={[...path, "fails_above"]}
            label={
              unitText(unit) === ""
                ? say("rubric.fails_above_number")
                : say("rubric.fails_above", { unit: unitText(unit) })
            }
            hint={say("rubric.does_not")}
            optional
          />
        )}
      </div>
      <Steps form={form} path={[...path, "map"]} unit={unit} />
      <DocumentText form={form} path={[...path, "comment"]} label={say("rubric.advice")} maxLength={1000} />
      <div class="button-row">
        <Button
          kind="small"
          blocked={place === 0 ? say("rubric.is_first") : undefined}
          tip={say("rubric.up_which", { name })}
          onClick={() => move(place - 1)}
        >
          <Brief shown={say("rubric.up")} full={say("rubric.up_which", { name })} />
        </Button>
        <Button
          kind="small"
          blocked={place === count - 1 ? say("rubric.is_last") : undefined}
          tip={say("rubric.down_which", { name })}
          onClick={() => move(place + 1)}
        >
          <Brief shown={say("rubric.down")} full={say("rubric.down_which", { name })} />
        </Button>
        <Button
          kind="small"
          blocked={undefined}
          tip={say("rubric.remove_which", { name })}
          onClick={() => form.edit.set(path, undefined)}
        >
          <Brief shown={say("common.remove")} full={say("rubric.remove_which", { name })} />
        </Button>
      </div>
    </fieldset>
  );
}

// Rows of value and share that is kept, linear in between: where the first point is lost, and the last one.
function Steps({ form, path, unit }: { readonly form: DocumentForm; readonly path: Path; readonly unit: string }) {
  const rows = itemsAt(form.edit.at(path));
  const last = rows.at(-1);
  const next = typeof valueAt(last ?? null, [0]) === "number" ? Number(valueAt(last ?? null, [0])) + 1 : 0;
  const problem = problemAt(form, path);
  return (
    <div class="map-rows">
      {problem !== undefined && <p class="field-problem">{problem}</p>}
      {rows.map((_row, i) => (
        <div class="map-row" key={i}>
          <DocumentNumber
            form={form}
            path={[...path, i, 0]}
            label={unitText(unit) === "" ? say("rubric.at_number") : say("rubric.at", { unit: unitText(unit) })}
          />
          <DocumentNumber form={form} path={[...path, i, 1]} label={say("rubric.share")} scale={0.01} min={0} />
          <Button
            kind="small"
            blocked={rows.length === 1 ? say("rubric.is_only") : undefined}
            tip={say("rubric.remove_row", { number: String(i + 1) })}
            onClick={() => form.edit.set([...path, i], undefined)}
          >
            <Brief shown={say("common.remove")} full={say("rubric.remove_row", { number: String(i + 1) })} />
          </Button>
        </div>
      ))}
      <div>
        <button type="button" class="button small" onClick={() => form.edit.set([...path, rows.length], [next, 0])}>
          {say("rubric.add_row")}
        </button>
      </div>
    </div>
  );
}
