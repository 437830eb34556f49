import type { ComponentChildren } from "preact";
import type { LabReport, LabSection, LabTable } from "../../api/lab_report";
import { say } from "../../base/words";
import { Card, TableFrame } from "../basics";
import { FigurePlot, VerdictMap } from "./figure_plot";

// What enamel-lab found: its figures, then section by section tables, plots and maps, at last where
// every number of a device is from.
export function LabReportView({ report, aside }: { readonly report: LabReport; readonly aside?: ComponentChildren }) {
  return (
    <>
      <Card title={say("lab.found")} aside={aside}>
        <ul class="lab-cards" aria-label={say("calibration.figures")}>
          {report.cards.map((card) => (
            <li key={card.text} class={card.good ? "" : "missed"}>
              <b>{card.figure}</b> {card.text}
            </li>
          ))}
        </ul>
        {report.sources.map((source) => (
          <Sources key={source.title} source={source} />
        ))}
      </Card>
      {report.sections.map((section) => (
        <Section key={section.title} section={section} />
      ))}
    </>
  );
}

function Sources({ source }: { readonly source: LabReport["sources"][number] }) {
  return (
    <details class="numbers">
      <summary>{say("lab.where_from", { device: source.title })}</summary>
      <TableFrame label={say("lab.sources_of", { device: source.title })}>
        <table class="dense">
          <tbody>
            {source.numbers.map((number) => (
              <tr key={number.what}>
                <th scope="row">{number.what}</th>
                <td>{number.source}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </TableFrame>
    </details>
  );
}

function Section({ section }: { readonly section: LabSection }) {
  return (
    <Card title={section.title}>
      {section.text !== "" && <p>{section.text}</p>}
      {section.plots.map((plot) => (
        <FigurePlot key={plot.title} plot={plot} />
      ))}
      {section.maps.map((map) => (
        <VerdictMap key={map.title} map={map} />
      ))}
      {section.tables.map((table) => (
        <Table key={table.title} table={table} />
      ))}
    </Card>
  );
}

function Table({ table }: { readonly table: LabTable }) {
  const bad = new Set(table.bad.map(([row, column]) => `${row} ${column}`));
  return (
    <section class="lab-table">
      <h3>{table.title}</h3>
      {table.rows.length > 0 && (
        <TableFrame label={table.title}>
          <table class="dense">
            <thead>
              <tr>
                {table.head.map((name, column) => (
                  <th key={column} scope="col">
                    {name}
                  </th>
                ))}
              </tr>
            </thead>
            <tbody>
              {table.rows.map((row, at) => (
                <tr key={at}>
                  {row.map((cell, column) => (
                    <td key={column} class={bad.has(`${at} ${column}`) ? "missed" : ""}>
                      {cell}
                    </td>
                  ))}
                </tr>
              ))}
            </tbody>
          </table>
        </TableFrame>
      )}
      {table.note !== "" && <p class="hint">{table.note}</p>}
    </section>
  );
}
