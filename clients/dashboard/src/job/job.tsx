import { Title } from "../app/title";

export function JobPage() {
  return <Title text="JobPage" />;
}
