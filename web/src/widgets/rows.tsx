import { Fragment } from "preact";
import { useEffect, useImperativeHandle, useRef, useState } from "preact/hooks";
import { focusRow, kWhole, type RowsProps } from "./row_place";

// The body of a table. Of a long one only what is in the window and around it.
export function Rows(props: RowsProps) {
  const long = props.keys.length > kWhole;
  const script = useScript(long);
  if (long && script !== undefined) return <script.ManyRows {...props} />;
  return <Few {...props} />;
}

// Of a long table the first rows, until its script is there.
function Few({ keys, row, handle }: RowsProps) {
  const body = useRef<HTMLTableSectionElement>(null);
  useImperativeHandle(handle ?? null, () => ({ focus: (index) => focusRow(body.current, index) }), []);
  return (
    <tbody ref={body} role="rowgroup">
      {keys.slice(0, kWhole).map((key, index) => (
        <Fragment key={key}>{row(index, { "data-index": index })}</Fragment>
      ))}
    </tbody>
  );
}

type Script = typeof import("./windowed");
let there: Script | undefined;

// Fetched with the first long table.
function useScript(wanted: boolean): Script | undefined {
  const [script, setScript] = useState(there);
  useEffect(() => {
    if (!wanted || script !== undefined) return;
    import("./windowed").then(
      (loaded) => {
        there = loaded;
        setScript(loaded);
      },
      () => undefined, // the first rows stay
    );
  }, [wanted, script]);
  return script;
}
