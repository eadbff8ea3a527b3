import { Title } from "../app/title";

export function Compare() {
  return <Title text="Compare" />;
}
