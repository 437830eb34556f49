import type { ComponentChildren } from "preact";
import { AuditPage } from "../features/operations/audit_page";
import { HealthPage } from "../features/operations/health_page";
import { JobsPage } from "../features/operations/jobs_page";
import { PeoplePage } from "../features/people/people_page";
import { PersonPage } from "../features/people/person_page";
import { RosterPage } from "../features/people/roster_page";
import { SearchPage } from "../features/people/search_page";
import type { ScreenProps } from "./routes";

// What who teaches seldom opens, and admins: one part of the page, since each part costs a request
// and its head.
export { InsightCard } from "../features/assignments/insight_card";
export { MarkingCard } from "../features/marking/marking_card";
export { ProfilePage } from "../features/profiles/profile_page";
export { ProfilesPage } from "../features/profiles/profiles_page";

// The screens of admins alone, which isForAdmins names.
export function adminScreen({ client, route, person, onQuery, onOpen }: ScreenProps): ComponentChildren {
  switch (route.name) {
    case "people":
      return <PeoplePage client={client} query={route.query} onQuery={onQuery} />;
    case "person":
      return (
        <PersonPage client={client} id={route.id} self={route.id === person.id} onGone={() => onOpen("/people")} />
      );
    case "search":
      return <SearchPage client={client} query={route.query} onQuery={onQuery} />;
    case "roster":
      return <RosterPage client={client} />;
    case "health":
      return <HealthPage client={client} />;
    case "jobs":
      return <JobsPage client={client} query={route.query} onQuery={onQuery} />;
    case "audit":
      return <AuditPage client={client} query={route.query} onQuery={onQuery} />;
    default:
      return null;
  }
}
