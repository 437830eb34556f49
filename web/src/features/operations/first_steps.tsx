import type { Client } from "../../api/client";
import { useRequest } from "../../api/use_request";
import { ok } from "../../base/result";
import { say } from "../../base/words";
import { Badge, Card } from "../../widgets/basics";

interface Step {
  readonly title: string;
  readonly text: string;
  readonly done: boolean;
  readonly link?: { readonly path: string; readonly title: string };
}

// From an empty server to a class that can begin, on the page alone; gone once all of it is done.
export function FirstSteps({
  client,
  backedUp,
  stations,
}: {
  readonly client: Client;
  readonly backedUp: boolean;
  readonly stations: number;
}) {
  const { loaded } = useRequest("first steps", async (signal) => {
    const [exercises, students, cohorts, assignments] = await Promise.all([
      client.all("/exercises", { state: "published", signal }),
      client.page("/people", { role: "student", limit: 1, signal }),
      client.all("/cohorts", { signal }),
      client.all("/assignments", { signal }),
    ]);
    if (!exercises.ok) return exercises;
    if (!students.ok) return students;
    if (!cohorts.ok) return cohorts;
    return assignments.ok
      ? ok({
          exercises: exercises.value.length,
          students: students.value.items.length,
          cohorts: cohorts.value.length,
          assignments: assignments.value.length,
        })
      : assignments;
  });
  if (loaded.state !== "ready") return null;
  const { exercises, students, cohorts, assignments } = loaded.value;
  const steps: readonly Step[] = [
    {
      title: say("steps.teeth"),
      text: say("steps.teeth_text"),
      done: exercises > 0,
      link: { path: "/exercises?import=tooth", title: say("tooth_import.ask") },
    },
    {
      title: say("nav.people"),
      text: say("steps.people_text"),
      done: students > 0,
      link: { path: "/roster", title: say("steps.import") },
    },
    {
      title: say("steps.cohort"),
      text: say("steps.cohort_text"),
      done: cohorts > 0,
      link: { path: "/cohorts", title: say("nav.cohorts") },
    },
    {
      title: say("steps.station"),
      text: say("steps.station_text"),
      done: stations > 0,
      link: { path: "/stations", title: say("nav.stations") },
    },
    {
      title: say("steps.work"),
      text: say("steps.work_text"),
      done: assignments > 0,
      link: { path: "/assignments", title: say("nav.assignments") },
    },
    { title: say("steps.backup"), text: say("steps.backup_text"), done: backedUp },
  ];
  if (steps.every((step) => step.done)) return null;
  return (
    <Card
      title={say("steps.title", {
        done: String(steps.filter((step) => step.done).length),
        count: String(steps.length),
      })}
    >
      <ol class="steps">
        {steps.map((step) => (
          <li key={step.title}>
            <b>{step.title}</b>{" "}
            {step.done ? (
              <Badge tone="good">{say("steps.done")}</Badge>
            ) : (
              <>
                – {step.text} {step.link !== undefined && <a href={step.link.path}>{step.link.title}</a>}
              </>
            )}
          </li>
        ))}
      </ol>
    </Card>
  );
}
