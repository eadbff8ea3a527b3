import { Title } from "../app/title";

export function Jobs() {
  return <Title text="Jobs" />;
}
