import { useState } from "preact/hooks";
import { type Json, type Path, valueAt } from "../../base/document";
import { unitText } from "../../base/format";
import { say, sayIf } from "../../base/words";
import { Brief } from "../../widgets/basics";
import { Button } from "../../widgets/button";
import { type DocumentForm, DocumentNumber, problemAt } from "../../widgets/document_fields";
import { SelectField, TextField } from "../../widgets/form";
import { itemsAt, materialPrices } from "./editor_text";
import { freshPrice, kChosen, kPriced, measuredOf, type PricedKind, priceOf, priceText, priceTitle } from "./price";
import { PriceCurve } from "./price_curve";

const kMaxSource = 500;

// What each part of the cut costs.
export function PriceFields({ form, path }: { readonly form: DocumentForm; readonly path: Path }) {
  const list = [...path, "prices"];
  const prices = itemsAt(form.edit.at(list));
  const problem = problemAt(form, list);
  return (
    <>
      {problem !== undefined && <p class="field-problem">{problem}</p>}
      {prices.map((item, i) => (
        <PriceItem key={i} form={form} rubric={path} list={list} place={i} only={prices.length === 1} item={item} />
      ))}
      <AddPrice form={form} list={list} prices={prices} />
    </>
  );
}

function AddPrice({
  form,
  list,
  prices,
}: {
  readonly form: DocumentForm;
  readonly list: Path;
  readonly prices: readonly Json[];
}) {
  const used = new Set(prices.map((item) => valueAt(item, ["of"])));
  const free = (Object.keys(kPriced) as PricedKind[]).filter((kind) => !used.has(kind));
  const [chosen, setChosen] = useState<PricedKind>();
  const kind = free.find((each) => each === chosen) ?? free[0];
  if (kind === undefined) return null;
  return (
    <div class="price-add">
      <SelectField
        label={say("price.another")}
        value={kind}
        options={free.map((value) => ({ value, title: priceTitle(value) }))}
        onValue={setChosen}
      />
      <button type="button" class="button" onClick={() => form.edit.set(list, [...prices, freshPrice(kind)])}>
        {say("price.add")}
      </button>
    </div>
  );
}

interface ItemProps {
  readonly form: DocumentForm;
  readonly rubric: Path;
  readonly list: Path;
  readonly place: number;
  readonly only: boolean;
  readonly item: Json;
}

function PriceItem({ form, rubric, list, place, only, item }: ItemProps) {
  const path = [...list, place];
  const of = String(valueAt(item, ["of"]) ?? "");
  const title = priceTitle(of);
  const measured = measuredOf(of);
  const price = priceOf(item);
  const material = materialPrices(form.edit.at(rubric)).has(of)
    ? String(form.edit.at([...rubric, "restoration"]))
    : undefined;
  const problem = problemAt(form, path) ?? problemAt(form, [...path, "of"]);
  const unit = unitText(measured?.unit ?? "");
  const twoSided = measured?.over !== undefined && measured.left !== undefined;
  return (
    <fieldset class="group price">
      <legend>{title}</legend>
      {problem !== undefined && <p class="field-problem">{problem}</p>}
      <div class="price-head">
        <div>
          <p>{price === undefined ? say("price.no_curve") : priceText(price)}</p>
          {material !== undefined && (
            <p class="hint">{say("price.material", { material: sayIf(`material.${material}`) ?? material })}</p>
          )}
        </div>
        {price !== undefined && <PriceCurve price={price} />}
      </div>
      <div class="price-figures">
        {measured?.over !== undefined && (
          <DocumentNumber
            form={form}
            path={[...path, measured.over]}
            label={say(twoSided ? "price.over_field" : "price.removed_field", { unit })}
            min={0}
          />
        )}
        {measured?.left !== undefined && (
          <DocumentNumber
            form={form}
            path={[...path, measured.left]}
            label={say("price.left_field", { unit })}
            min={0}
          />
        )}
        <DocumentNumber form={form} path={[...path, "points"]} label={say("price.points_field")} min={0} />
        <DocumentNumber form={form} path={[...path, "most"]} label={say("price.most_field")} min={0} />
        <DocumentNumber form={form} path={[...path, "modify_points"]} label={say("price.modify_field")} min={0} />
        <DocumentNumber form={form} path={[...path, "redo_points"]} label={say("price.redo_field")} min={0} />
      </div>
      <div class="price-foot">
        <Source form={form} path={[...path, "source"]} />
        <Button
          kind="small"
          blocked={only ? say("rubric.is_only") : undefined}
          tip={say("rubric.remove_which", { name: title })}
          onClick={() => form.edit.set(path, undefined)}
        >
          <Brief shown={say("common.remove")} full={say("rubric.remove_which", { name: title })} />
        </Button>
      </div>
    </fieldset>
  );
}

// A document that names no source says that the figures were chosen.
function Source({ form, path }: { readonly form: DocumentForm; readonly path: Path }) {
  const source = form.edit.at(path);
  return (
    <TextField
      label={say("price.source_field")}
      hint={say("price.source_hint")}
      problem={problemAt(form, path)}
      value={typeof source === "string" && source !== kChosen ? source : ""}
      onValue={(text) => form.edit.set(path, text === "" ? kChosen : text)}
      maxLength={kMaxSource}
    />
  );
}
