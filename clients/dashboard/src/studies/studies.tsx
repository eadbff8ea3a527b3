import { Title } from "../app/title";

export function Studies() {
  return <Title text="Studies" />;
}
