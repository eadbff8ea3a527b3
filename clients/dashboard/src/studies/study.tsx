import { Title } from "../app/title";

export function Study() {
  return <Title text="Study" />;
}
